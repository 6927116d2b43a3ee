// A file with each of meshoptimizer's modes and filters, one buffer view each.

import { MeshoptEncoder } from "meshoptimizer";
import { glb } from "./glb.mjs";
import { scene } from "./scene.mjs";

/** The vase as a GLB: its indices in both modes, and attributes through every filter that the extension has. */
export function everyMode(extension) {
  const isKhr = extension === "KHR_meshopt_compression";
  const document = scene();
  const [vase] = document.getRoot().listMeshes();
  const [primitive] = vase.listPrimitives();
  const attribute = (name) => primitive.getAttribute(name).getArray();
  const count = primitive.getAttribute("POSITION").getCount();
  const file = new Compressed(extension, isKhr ? 1 : 0);
  const indices = primitive.getIndices().getArray();
  const short = { componentType: 5123, type: "SCALAR" };
  const triangles = file.accessor(indices.slice(), indices.length, 2, "TRIANGLES", "NONE", short);
  const sequence = file.accessor(Uint32Array.from(indices), indices.length, 4, "INDICES", "NONE", { ...short, componentType: 5125 });
  const positions = MeshoptEncoder.encodeFilterExp(attribute("POSITION"), count, 12, 15);
  const position = file.accessor(positions, count, 12, "ATTRIBUTES", "EXPONENTIAL", { componentType: 5126, type: "VEC3" });
  const four = (values) => Float32Array.from({ length: 4 * count }, (_, at) => (at % 4 < 3 ? values[3 * (at >> 2) + (at % 4)] : 0));
  const normals = four(attribute("NORMAL"));
  const normal = (bits, stride, componentType) => {
    const coded = MeshoptEncoder.encodeFilterOct(normals, count, stride, bits);
    return file.accessor(coded, count, stride, "ATTRIBUTES", "OCTAHEDRAL", { componentType, type: "VEC3", normalized: true }, stride);
  };
  const coords = file.accessor(attribute("TEXCOORD_0").slice(), count, 8, "ATTRIBUTES", undefined, { componentType: 5126, type: "VEC2" });
  const colors = Float32Array.from(attribute("COLOR_0"), (byte) => byte / 255);
  const color = (bits, stride, componentType) => {
    const json = { componentType, type: "VEC4", normalized: true };
    if (isKhr) return file.accessor(MeshoptEncoder.encodeFilterColor(colors, count, stride, bits), count, stride, "ATTRIBUTES", "COLOR", json);
    const whole = stride === 4 ? Uint8Array.from(colors, (c) => Math.round(255 * c)) : Uint16Array.from(colors, (c) => Math.round(65535 * c));
    return file.accessor(whole, count, stride, "ATTRIBUTES", "NONE", json);
  };
  const mesh = (index, normal, color) => ({
    primitives: [{ indices: index, attributes: { POSITION: position, NORMAL: normal, TEXCOORD_0: coords, COLOR_0: color } }],
  });
  const meshes = [mesh(triangles, normal(8, 4, 5120), color(8, 4, 5121)), mesh(sequence, normal(12, 8, 5122), color(12, 8, 5123))];
  const nodes = [{ mesh: 0, translation: [-0.9, 0, 0] }, { mesh: 1, translation: [0.9, 0, 0] }];
  const times = Float32Array.from([0, 0.5, 1]);
  const rotations = Float32Array.from([...times].flatMap((time) => [0, Math.sin(time), 0, Math.cos(time)]));
  const coded = MeshoptEncoder.encodeFilterQuat(rotations, times.length, 8, 12);
  const input = file.accessor(times, times.length, 4, "ATTRIBUTES", "NONE", { componentType: 5126, type: "SCALAR" });
  const output = file.accessor(coded, times.length, 8, "ATTRIBUTES", "QUATERNION", { componentType: 5122, type: "VEC4", normalized: true });
  const channels = [{ sampler: 0, target: { node: 0, path: "rotation" } }];
  return file.glb({ meshes, nodes, animations: [{ name: "turn", channels, samplers: [{ input, output }] }] });
}

class Compressed {
  constructor(extension, version) {
    Object.assign(this, { extension, version, views: [], accessors: [], parts: [], length: 0, whole: 0 });
  }

  /** Adds elements, of which filters have made what they will undo, and gives the accessor's number. */
  accessor(values, count, size, mode, filter, json, byteStride) {
    const bytes = new Uint8Array(values.buffer, values.byteOffset, count * size);
    const coded = MeshoptEncoder.encodeGltfBuffer(bytes, count, size, mode, this.version);
    const compressed = { buffer: 0, byteOffset: this.length, byteLength: coded.length, byteStride: size, count, mode, filter };
    this.views.push({
      buffer: 1,
      byteOffset: this.whole,
      byteLength: count * size,
      byteStride,
      extensions: { [this.extension]: compressed },
    });
    const padded = Buffer.alloc(4 * Math.ceil(coded.length / 4));
    padded.set(coded);
    this.parts.push(padded);
    this.length += padded.length;
    this.whole += 4 * Math.ceil((count * size) / 4);
    return this.accessors.push({ bufferView: this.views.length - 1, count, ...json }) - 1;
  }

  glb(scene) {
    const fallback = { byteLength: this.whole, extensions: { [this.extension]: { fallback: true } } };
    const json = {
      asset: { version: "2.0" },
      extensionsUsed: [this.extension],
      extensionsRequired: [this.extension],
      buffers: [{ byteLength: this.length }, fallback],
      bufferViews: this.views,
      accessors: this.accessors,
      ...scene,
    };
    return glb(json, Buffer.concat(this.parts));
  }
}
