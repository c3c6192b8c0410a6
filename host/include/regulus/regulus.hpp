// All of Regulus for a program that calls it.
//
//     using namespace regulus;
//     const Prepared scene = prepare(load("scene.gltf"));
//     Renderer renderer(make_plan(scene, Settings().set("spp", 64)), open_device());
//     renderer.render();
//     write_picture("picture.exr", renderer.picture());
//
// Link regulus::regulus (find_package(regulus)). Errors are exceptions of type regulus::Error.
#pragma once

#include "regulus/check.hpp"
#include "regulus/error.hpp"
#include "regulus/image.hpp"
#include "regulus/render.hpp"
#include "regulus/scene.hpp"
#include "regulus/settings.hpp"
