// Writes expected_positions.json: where three.js, an independent implementation of glTF's skins, morph targets
// and animations, puts the corners of triangles. Made with Node 20 and three 0.170.0:
//
//   npm install three@0.170.0
//   node expected_positions.mjs ../../../../shared/assets/gltf > expected_positions.json
//
// Materials and images are left out: positions do not need them, and Node cannot decode images.
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import * as THREE from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

globalThis.self = globalThis;
globalThis.ProgressEvent = class {};

// File, and the times of its animations at which it is looked at, by index or name; at rest it always is.
const CASES = [
  ["bevy/SimpleSkin/SimpleSkin.gltf", { 0: [-1, 0.75, 2.25, 99] }],
  ["bevy/Fox.glb", { Survey: [1.234], Walk: [0.3, 50], Run: [0.511] }],
  ["bevy/MorphStressTest.gltf", { 0: [0.4], TheWave: [2.7] }],
  ["blender-io/01_morphed_cube/01_morphed_cube.gltf", { 0: [0.1, 1.3] }],
  ["blender-io/03_skinned_cylinder/03_skinned_cylinder.gltf", { 0: [0.77] }],
  ["blender-io/05_metallic_sphere_light/05_metallic_sphere_light.gltf", { 0: [0.6] }],
  ["blender-io/23_multi_prim_vertex_attribute/23_multi_prim_vertex_attribute.gltf", { 0: [0.5] }],
  ["playcanvas/bitmoji.glb", {}],
  ["tinygltf/models/SparseMorphTargets-issue280/singleBlendshapeCube_sparse.glb", { 0: [0.9] }],
];
const SAMPLED_TRIANGLES = 8;

function readDocument(path) {
  const bytes = readFileSync(path);
  let json, binary;
  if (bytes.toString("latin1", 0, 4) === "glTF") {
    const length = bytes.readUInt32LE(12);
    json = JSON.parse(bytes.toString("utf8", 20, 20 + length));
    binary = bytes.subarray(20 + length + 8);
  } else {
    json = JSON.parse(bytes.toString("utf8"));
  }
  for (const buffer of json.buffers) {
    if (buffer.uri?.startsWith("data:")) continue;
    const content = buffer.uri ? readFileSync(join(dirname(path), decodeURIComponent(buffer.uri))) : binary;
    buffer.uri = "data:application/octet-stream;base64," + content.toString("base64");
  }
  for (const part of ["materials", "textures", "images", "samplers"]) delete json[part];
  for (const mesh of json.meshes) for (const primitive of mesh.primitives) delete primitive.material;
  return JSON.stringify(json);
}

// SimpleSkin has keys of .707, of which three.js makes a rotation that shrinks by 3e-4: they become unit
// quaternions, as glTF demands.
function normalizeRotations(clip) {
  for (const track of clip.tracks) {
    if (track.ValueTypeName !== "quaternion" || track.values.length !== 4 * track.times.length) continue;
    for (let i = 0; i < track.values.length; i += 4)
      new THREE.Quaternion().fromArray(track.values, i).normalize().toArray(track.values, i);
  }
}

// The animation at a time, clamped at both ends as glTF demands.
function pose(gltf, animation, time) {
  const clip = gltf.animations.find((clip) => clip.name === animation) ?? gltf.animations[animation];
  normalizeRotations(clip);
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const action = mixer.clipAction(clip);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  mixer.setTime(Math.min(Math.max(time, 0), clip.duration));
}

function triangleCorners(scene) {
  scene.updateMatrixWorld(true);
  const corners = [];
  scene.traverse((object) => {
    if (!object.isMesh) return;
    const index = object.geometry.index;
    const count = index ? index.count : object.geometry.attributes.position.count;
    for (let i = 0; i < count; ++i) {
      const point = object.getVertexPosition(index ? index.getX(i) : i, new THREE.Vector3());
      corners.push(point.applyMatrix4(object.matrixWorld).toArray());
    }
  });
  return corners;
}

function summary(corners) {
  const triangles = corners.length / 3;
  const mean = [0, 1, 2].map((axis) => corners.reduce((sum, p) => sum + p[axis], 0) / corners.length);
  const meanSquare = [0, 1, 2].map((axis) => corners.reduce((sum, p) => sum + p[axis] ** 2, 0) / corners.length);
  const sampled = [];
  for (let i = 0; i < Math.min(SAMPLED_TRIANGLES, triangles); ++i) {
    const t = Math.floor((i * triangles) / Math.min(SAMPLED_TRIANGLES, triangles));
    sampled.push([t, ...corners.slice(3 * t, 3 * t + 3).flat()].map((x) => Number(x.toPrecision(9))));
  }
  return { triangles, mean, meanSquare, sampled };
}

const results = [];
for (const [file, animations] of CASES) {
  const document = readDocument(join(process.argv[2], file));
  const poses = [[null, 0]];
  for (const [animation, times] of Object.entries(animations)) for (const t of times) poses.push([animation, t]);
  for (const [animation, time] of poses) {
    const gltf = await new GLTFLoader().parseAsync(document, "");
    if (animation !== null) pose(gltf, animation, time);
    results.push({ file, animation, time, ...summary(triangleCorners(gltf.scene)) });
  }
}
console.log("[\n" + results.map((result) => JSON.stringify(result)).join(",\n") + "\n]");
