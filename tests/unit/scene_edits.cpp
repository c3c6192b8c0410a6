// Edits of a scene's document: which are taken, where they go, and what is said of the others.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "scene/edits.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

json document() {
  return json::parse(R"({
    "asset": {"version": "2.0"},
    "materials": [{"name": "Glass"}, {"name": "Glass.v2", "pbrMetallicRoughness": {"roughnessFactor": 0.5}},
                  {}, {"name": "twin"}, {"name": "twin"}, {"name": "a=b"}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}},
                {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}],
    "nodes": [{"name": "Lamp"}, {"name": "fixed", "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]},
              {"name": "moved", "translation": [1, 2, 3]}],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "name": "Spot"}, {"type": "point"}]}}})");
}

/// What an edit changes, as a patch (RFC 6902), and the record of it.
json change(const std::string& edit) {
  json edited = document();
  apply_edits(edited, {edit});
  return json::diff(document(), edited);
}

std::string refusal(const std::string& edit) {
  json edited = document();
  try {
    apply_edits(edited, {edit});
  } catch (const SettingError& error) {
    EXPECT_EQ(edited, document()) << edit;
    return error.what();
  }
  return "taken";
}

json added(const char* path, const json& value) {
  return json::array({{{"op", "add"}, {"path", path}, {"value", value}}});
}

json replaced(const char* path, const json& value) {
  return json::array({{{"op", "replace"}, {"path", path}, {"value", value}}});
}

TEST(SceneEdits, GoWhereTheFileHasTheProperty) {
  EXPECT_EQ(change("materials.Glass.roughness=0.1"),
            added("/materials/0/pbrMetallicRoughness", {{"roughnessFactor", 0.1}}));
  EXPECT_EQ(change("materials.Glass.v2.roughness=0.1"),
            replaced("/materials/1/pbrMetallicRoughness/roughnessFactor", 0.1));
  EXPECT_EQ(change("materials.Glass.v2.pbrMetallicRoughness.roughnessFactor=0.1"),
            replaced("/materials/1/pbrMetallicRoughness/roughnessFactor", 0.1));
  EXPECT_EQ(change("materials.2.doubleSided=true"), added("/materials/2/doubleSided", true));
  EXPECT_EQ(change("materials.a=b.emissive=1,2,3"), added("/materials/5/emissiveFactor", {1.0, 2.0, 3.0}));
  EXPECT_EQ(change("materials.2.color=.1,.2,.3"),
            added("/materials/2/pbrMetallicRoughness", {{"baseColorFactor", {.1, .2, .3, 1.0}}}));
  EXPECT_EQ(change("cameras.0.yfov=0.5"), replaced("/cameras/0/perspective/yfov", 0.5));
  EXPECT_EQ(change("cameras.1.znear=1"), replaced("/cameras/1/orthographic/znear", 1.0));
  EXPECT_EQ(change("nodes.Lamp.translation=0,2,0"), added("/nodes/0/translation", {0.0, 2.0, 0.0}));
  EXPECT_EQ(change("lights.Spot.innerConeAngle=.2"),
            added("/extensions/KHR_lights_punctual/lights/0/spot", {{"innerConeAngle", .2}}));
}

TEST(SceneEdits, AnnounceTheExtensionTheyNeed) {
  json edited = document();
  apply_edits(edited, {"materials.Glass.ior=1.7", "materials.Glass.transmission=1"});
  EXPECT_EQ(edited["extensionsUsed"], json({"KHR_materials_ior", "KHR_materials_transmission"}));
  EXPECT_EQ(edited["materials"][0]["extensions"]["KHR_materials_ior"]["ior"], 1.7);
}

TEST(SceneEdits, TheLaterOfTwoCounts) {
  json edited = document();
  const auto done = apply_edits(
      edited, {"materials.Glass.roughness=0.1", "materials.2.metallic=1", "materials.0.roughness=0.2"});
  EXPECT_EQ(done, (std::vector<std::string>{"materials/0/pbrMetallicRoughness/roughnessFactor=0.2",
                                            "materials/2/pbrMetallicRoughness/metallicFactor=1.0"}));
}

TEST(SceneEdits, OfWhatThereIsNotSayWhatIsNear) {
  const std::pair<const char*, const char*> cases[] = {
      {"materials.Glas.roughness=1", "did you mean Glass"},
      {"material.Glass.roughness=1", "did you mean materials"},
      {"materials.Glass.roughnes=1", "did you mean roughness"},
      {"materials.9.roughness=1", "there is no \"9\" among the 6"},
      {"materials.twin.roughness=1", "more than one"},
      {"materials.Glass.roughness", "expected ARRAY.ELEMENT.PROPERTY=VALUE"},
      {"=", "expected ARRAY"},
      {"", "expected ARRAY"},
      {"materials=1", "expected ARRAY"},
      {"materials.Glass.roughness=", "finite number"},
      {"materials.Glass.roughness=nan", "finite number"},
      {"materials.Glass.roughness=inf", "finite number"},
      {"materials.Glass.roughness=1e999", "finite number"},
      {"materials.Glass.roughness=0.1,0.2", "finite number"},
      {"materials.Glass.roughness=0.1 ", "finite number"},
      {"materials.Glass.doubleSided=1", "true or false"},
      {"nodes.Lamp.translation=0,2", "3 finite numbers"},
      {"nodes.Lamp.translation=0,2,", "3 finite numbers"},
      {"nodes.fixed.scale=1,1,1", "has a matrix"},
      {"nodes.moved.matrix=1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1", "in place of a matrix"},
      {"cameras.0.xmag=1", "no orthographic"},
      {"cameras.1.yfov=1", "is orthographic"},
      {"lights.1.innerConeAngle=.2", "no spot"},
      {"textures.0.roughness=1", "\"textures\" is not one of"}};
  for (const auto& [edit, part] : cases)
    EXPECT_NE(refusal(edit).find(part), std::string::npos) << edit << ": " << refusal(edit);
}

TEST(SceneEdits, SurviveDocumentsOfAnyShape) {
  for (const char* text :
       {"{}", R"({"materials": 3})", R"({"materials": [1, "x", null]})", R"({"materials": {"a": {}}})",
        R"({"materials": [{"name": 3, "pbrMetallicRoughness": 7}]})",
        R"({"materials": [{"extensions": []}], "extensionsUsed": "no"})",
        R"({"extensions": {"KHR_lights_punctual": []}})"}) {
    for (const char* edit :
         {"materials.0.roughness=1", "materials.1.ior=2", "lights.0.intensity=3", "cameras.0.yfov=1"}) {
      json edited = json::parse(text);
      try {
        apply_edits(edited, {edit});
      } catch (const SettingError&) {
      }
    }
  }
}

}  // namespace
}  // namespace regulus::scene
