// glTF materials to the renderer's own.
#pragma once

#include "scene/document.hpp"
#include "scene/scene.hpp"
#include "scene/texture.hpp"

namespace regulus::scene {

/// True if shading a material needs tangents.
bool needs_tangents(const tinygltf::Material& material);

/// False only if nothing that has the material emits light.
bool may_emit(const tinygltf::Material& material);

/// False only if nothing that has the material bounds a refracting solid.
bool may_refract(const tinygltf::Material& material);

/// Fills Scene::materials (same indices as the file; one more, glTF's default material, if a triangle uses
/// it), their priorities where they overlap, and the textures of those that triangles use: those that are not
/// `loaded` into the scene already. Call after add_geometry.
/// @throws Error on values without meaning and on unreadable images.
void add_materials(Document& document, Scene& scene, LoadedTextures& loaded);

}  // namespace regulus::scene
