// Writes the scene of scene.mjs in every compressed form that is read, to the fuzzer's corpus, where tests find it.
//
//     npm ci && npm run make

import { Logger, NodeIO, Verbosity } from "@gltf-transform/core";
import { ALL_EXTENSIONS, KHRDracoMeshCompression } from "@gltf-transform/extensions";
import { dedup, meshopt, textureCompress } from "@gltf-transform/functions";
import draco3d from "draco3dgltf";
import { encodeToKTX2 } from "ktx2-encoder";
import { MeshoptDecoder, MeshoptEncoder } from "meshoptimizer";
import { writeFile } from "node:fs/promises";
import sharp from "sharp";
import { glb } from "./glb.mjs";
import { everyMode } from "./meshopt.mjs";
import { scene, texels } from "./scene.mjs";

const FOLDER = new URL("../../crates/verify/corpus/glb/", import.meta.url);

await MeshoptEncoder.ready;
const io = new NodeIO()
  .setLogger(new Logger(Verbosity.SILENT))
  .registerExtensions(ALL_EXTENSIONS)
  .registerDependencies({
    "draco3d.encoder": await draco3d.createEncoderModule(),
    "meshopt.decoder": MeshoptDecoder,
    "meshopt.encoder": MeshoptEncoder,
  });

async function write(name, document) {
  await save(name, await io.writeBinary(document));
}

async function save(name, bytes) {
  await writeFile(new URL(`${name}.glb`, FOLDER), bytes);
  console.log(`${name}.glb: ${bytes.length} bytes`);
}

await write("plain", scene());

for (const method of ["edgebreaker", "sequential"]) {
  const document = scene();
  const extension = document.createExtension(KHRDracoMeshCompression).setRequired(true);
  const bits = { POSITION: 14, NORMAL: 10, TEX_COORD: 12, COLOR: 8, GENERIC: 12 };
  extension.setEncoderOptions({ method: KHRDracoMeshCompression.EncoderMethod[method.toUpperCase()], quantizationBits: bits });
  await write(`draco-${method}`, document);
}

for (const level of ["medium", "high"]) {
  const document = scene();
  await document.transform(meshopt({ encoder: MeshoptEncoder, level }));
  await write(`meshopt-${level}`, document);
}

await save("meshopt-modes", everyMode("EXT_meshopt_compression"));
await save("meshopt-modes-khr", everyMode("KHR_meshopt_compression"));

for (const targetFormat of ["webp", "avif"]) {
  const document = scene();
  await document.transform(textureCompress({ encoder: sharp, targetFormat, lossless: true }), dedup());
  await write(targetFormat, document);
}

const { width, height, bytes } = texels();
const imageDecoder = async () => ({ data: bytes, width, height });
const ktx2 = {
  "basisu-etc1s": { isUASTC: false, qualityLevel: 255 },
  "basisu-uastc": { isUASTC: true, needSupercompression: false },
  "basisu-zstd": { isUASTC: true, needSupercompression: true },
};
for (const [name, options] of Object.entries(ktx2)) {
  const document = scene();
  const image = await encodeToKTX2(new Uint8Array(), { ...options, generateMipmap: false, isSetKTX2SRGBTransferFunc: true, imageDecoder });
  document.getRoot().listTextures()[0].setMimeType("image/ktx2").setImage(image);
  document.createExtension(ALL_EXTENSIONS.find((each) => each.EXTENSION_NAME === "KHR_texture_basisu")).setRequired(true);
  await write(name, document);
}

// What is in the JSON alone: other materials, nodes that come and go, channels that say by a path what they move, and words
// about the file.
const { json, resources } = await io.writeJSON(scene(), { format: "GLB" });
const parts = [resources["@glb.bin"]];

/** Adds an accessor to values, and gives its number. */
function add(values, type, componentType) {
  const before = Buffer.concat(parts);
  const bytes = Buffer.from(values.buffer, values.byteOffset, values.byteLength);
  const view = { buffer: 0, byteOffset: 4 * Math.ceil(before.length / 4), byteLength: bytes.length };
  parts.push(Buffer.alloc(view.byteOffset - before.length), bytes);
  const width = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 }[type];
  return json.accessors.push({ componentType, type, count: values.length / width, bufferView: json.bufferViews.push(view) - 1 }) - 1;
}

const [animation] = json.animations;
const input = add(Float32Array.of(0, 0.25, 0.5), "SCALAR", 5126);

/** Adds a channel. */
function move(path, output, interpolation) {
  const sampler = animation.samplers.push({ input, output, interpolation }) - 1;
  animation.channels.push({ sampler, target: pointer(path) });
}

const pointer = (path) => ({ path: "pointer", extensions: { KHR_animation_pointer: { pointer: path } } });
const [vase, strip] = json.meshes;
json.extensions = {
  KHR_lights_punctual: { lights: [{ type: "spot", intensity: 80, spot: { outerConeAngle: 0.6 } }] },
  KHR_materials_variants: { variants: [{ name: "clay" }, { name: "blue" }] },
  KHR_xmp_json_ld: { packets: [{ "@context": { dc: "http://purl.org/dc/elements/1.1/" }, "dc:title": "A vase" }] },
};
json.asset.extensions = { KHR_xmp_json_ld: { packet: 0 } };
const mappings = [0, 1].map((number) => ({ material: number, variants: [number] }));
vase.primitives[0].extensions = { KHR_materials_variants: { mappings } };
json.cameras = [{ type: "perspective", perspective: { yfov: 0.5, znear: 0.1 } }];
json.scenes[0].nodes.push(
  json.nodes.push({ camera: 0, translation: [-0.3, 0.6, 5] }) - 1,
  json.nodes.push({ extensions: { KHR_lights_punctual: { light: 0 } }, translation: [0, 1, 5] }) - 1,
);
const { target } = animation.channels[0];
animation.channels[0].target = pointer(`/nodes/${target.node}/rotation`);
const hidden = json.nodes.findIndex((node) => node.mesh === json.meshes.indexOf(strip));
json.nodes[hidden].extensions = { KHR_node_visibility: { visible: false } };
move(`/nodes/${hidden}/extensions/KHR_node_visibility/visible`, add(Uint8Array.of(1, 0, 1), "SCALAR", 5121), "STEP");
move("/materials/1/pbrMetallicRoughness/baseColorFactor", add(Float32Array.of(0.2, 0.5, 0.9, 1, 0.9, 0.1, 0.1, 1, 0.1, 0.8, 0.2, 1), "VEC4", 5126));
const offset = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset";
move(offset, add(Float32Array.of(0, 0, 0.25, 0, 0.5, 0.5), "VEC2", 5126));
move("/extensions/KHR_lights_punctual/lights/0/color", add(Float32Array.of(1, 1, 1, 1, 0.8, 0.6, 1, 1, 1), "VEC3", 5126));
move("/cameras/0/perspective/yfov", add(Float32Array.of(0.5, 0.4, 0.5), "SCALAR", 5126));
const extensionsRequired = ["KHR_node_visibility", "KHR_animation_pointer"];
const extensionsUsed = [...extensionsRequired, "KHR_lights_punctual", "KHR_materials_variants", "KHR_texture_transform", "KHR_xmp_json_ld"];
const binary = Buffer.concat(parts);
json.buffers[0].byteLength = binary.length;
await save("variants", glb({ ...json, extensionsUsed, extensionsRequired }, binary));
