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

const webp = scene();
await webp.transform(textureCompress({ encoder: sharp, targetFormat: "webp", lossless: true }), dedup());
await write("webp", webp);

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
const extensionsUsed = ["KHR_materials_variants", "KHR_node_visibility", "KHR_animation_pointer", "KHR_xmp_json_ld"];
const [vase, strip] = json.meshes;
json.extensions = {
  KHR_materials_variants: { variants: [{ name: "clay" }, { name: "blue" }] },
  KHR_xmp_json_ld: { packets: [{ "@context": { dc: "http://purl.org/dc/elements/1.1/" }, "dc:title": "A vase" }] },
};
const mappings = [0, 1].map((number) => ({ material: number, variants: [number] }));
vase.primitives[0].extensions = { KHR_materials_variants: { mappings } };
const [animation] = json.animations;
const { target } = animation.channels[0];
const pointer = (path) => ({ path: "pointer", extensions: { KHR_animation_pointer: { pointer: path } } });
animation.channels[0].target = pointer(`/nodes/${target.node}/rotation`);
const hidden = json.nodes.findIndex((node) => node.mesh === json.meshes.indexOf(strip));
const values = Buffer.from([1, 0, 1, 0]);
const binary = resources["@glb.bin"];
const view = { buffer: 0, byteOffset: 4 * Math.ceil(binary.length / 4), byteLength: values.length };
const bytesOfAll = Buffer.alloc(view.byteOffset + values.length);
bytesOfAll.set(binary);
bytesOfAll.set(values, view.byteOffset);
json.buffers[0].byteLength = bytesOfAll.length;
const [input] = animation.samplers.map((sampler) => sampler.input);
const times = { ...json.accessors[input], count: 3 };
const accessor = { componentType: 5121, type: "SCALAR", count: 3, bufferView: json.bufferViews.push(view) - 1 };
json.accessors.push(times, accessor);
const output = json.accessors.length - 1;
animation.samplers.push({ input: output - 1, output, interpolation: "STEP" });
animation.channels.push({ sampler: 1, target: pointer(`/nodes/${hidden}/extensions/KHR_node_visibility/visible`) });
json.nodes[hidden].extensions = { KHR_node_visibility: { visible: false } };
json.asset.extensions = { KHR_xmp_json_ld: { packet: 0 } };
await save("variants", glb({ ...json, extensionsUsed, extensionsRequired: extensionsUsed.slice(1, 3) }, bytesOfAll));
