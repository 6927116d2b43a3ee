// The scene that all files hold: a vase with a texture, colours and normals, and a strip that bends at a joint.

import { Accessor, Document } from "@gltf-transform/core";
import { deflateSync } from "node:zlib";

const SEGMENTS = 12;
const RINGS = 6;
const TEXELS = 16;

/** The plain document, made anew. */
export function scene() {
  const document = new Document();
  const buffer = document.createBuffer();
  const accessor = (type, array) => document.createAccessor().setType(type).setArray(array).setBuffer(buffer);
  const texture = document.createTexture("squares").setMimeType("image/png").setImage(png());
  const clay = document
    .createMaterial("clay")
    .setBaseColorTexture(texture)
    .setMetallicFactor(0)
    .setRoughnessFactor(0.8)
    .setDoubleSided(true);
  const root = document.createScene("scene");
  root.addChild(document.createNode("vase").setMesh(vase(document, accessor, clay)).setTranslation([-0.9, 0, 0]));
  const arm = strip(document, accessor);
  root.addChild(arm.node).addChild(arm.skeleton);
  return document;
}

function vase(document, accessor, material) {
  const positions = [];
  const normals = [];
  const coords = [];
  const colors = [];
  const indices = [];
  for (let ring = 0; ring <= RINGS; ring++) {
    const height = ring / RINGS;
    const radius = 0.4 + 0.2 * Math.sin(5 * height);
    const slope = Math.cos(5 * height);
    for (let segment = 0; segment <= SEGMENTS; segment++) {
      const turn = (2 * Math.PI * segment) / SEGMENTS;
      const [x, z] = [Math.cos(turn), Math.sin(turn)];
      const length = Math.hypot(1, slope);
      positions.push(radius * x, height, radius * z);
      normals.push(x / length, -slope / length, z / length);
      coords.push(segment / SEGMENTS, 1 - height);
      colors.push(255, Math.round(255 * (1 - 0.5 * height)), Math.round(128 + 127 * x), 255);
    }
  }
  for (let ring = 0; ring < RINGS; ring++) {
    for (let segment = 0; segment < SEGMENTS; segment++) {
      const first = ring * (SEGMENTS + 1) + segment;
      const above = first + SEGMENTS + 1;
      indices.push(first, above, first + 1, first + 1, above, above + 1);
    }
  }
  const primitive = document
    .createPrimitive()
    .setIndices(accessor(Accessor.Type.SCALAR, new Uint16Array(indices)))
    .setAttribute("POSITION", accessor(Accessor.Type.VEC3, new Float32Array(positions)))
    .setAttribute("NORMAL", accessor(Accessor.Type.VEC3, new Float32Array(normals)))
    .setAttribute("TEXCOORD_0", accessor(Accessor.Type.VEC2, new Float32Array(coords)))
    .setAttribute("COLOR_0", accessor(Accessor.Type.VEC4, new Uint8Array(colors)).setNormalized(true))
    .setMaterial(material);
  return document.createMesh("vase").addPrimitive(primitive);
}

function strip(document, accessor) {
  const STEPS = 8;
  const positions = [];
  const joints = [];
  const weights = [];
  const indices = [];
  for (let step = 0; step <= STEPS; step++) {
    const height = step / STEPS;
    const bent = Math.min(1, Math.max(0, 2 * height - 0.5));
    for (const side of [-0.15, 0.15]) {
      positions.push(side, height, 0);
      joints.push(0, 1, 0, 0);
      weights.push(255 - Math.round(255 * bent), Math.round(255 * bent), 0, 0);
    }
    if (step < STEPS) {
      const at = 2 * step;
      indices.push(at, at + 1, at + 2, at + 2, at + 1, at + 3);
    }
  }
  const primitive = document
    .createPrimitive()
    .setIndices(accessor(Accessor.Type.SCALAR, new Uint16Array(indices)))
    .setAttribute("POSITION", accessor(Accessor.Type.VEC3, new Float32Array(positions)))
    .setAttribute("JOINTS_0", accessor(Accessor.Type.VEC4, new Uint8Array(joints)))
    .setAttribute("WEIGHTS_0", accessor(Accessor.Type.VEC4, new Uint8Array(weights)).setNormalized(true))
    .setMaterial(document.createMaterial("paper").setDoubleSided(true).setBaseColorFactor([0.2, 0.5, 0.9, 1]));
  const upper = document.createNode("upper").setTranslation([0, 0.5, 0]);
  const skeleton = document.createNode("lower").setTranslation([0.4, 0, 0]).addChild(upper);
  const inverse = new Float32Array(32);
  for (const [joint, down] of [0, -0.5].entries()) {
    for (const diagonal of [0, 5, 10, 15]) inverse[16 * joint + diagonal] = 1;
    inverse[16 * joint + 13] = down;
  }
  const skin = document
    .createSkin("skin")
    .addJoint(skeleton)
    .addJoint(upper)
    .setInverseBindMatrices(accessor(Accessor.Type.MAT4, inverse));
  bend(document, accessor, upper);
  const mesh = document.createMesh("strip").addPrimitive(primitive);
  return { node: document.createNode("strip").setMesh(mesh).setSkin(skin), skeleton };
}

function bend(document, accessor, joint) {
  const times = [0, 0.25, 0.5, 0.75, 1];
  const rotations = times.flatMap((time) => [0, 0, Math.sin(-0.6 * time), Math.cos(-0.6 * time)]);
  const sampler = document
    .createAnimationSampler()
    .setInput(accessor(Accessor.Type.SCALAR, new Float32Array(times)))
    .setOutput(accessor(Accessor.Type.VEC4, new Float32Array(rotations)));
  const channel = document.createAnimationChannel().setTargetNode(joint).setTargetPath("rotation").setSampler(sampler);
  document.createAnimation("bend").addSampler(sampler).addChannel(channel);
}

/** A picture of four squares in four colours, one of them transparent by half. */
export function texels() {
  const colors = [[230, 60, 40, 255], [250, 220, 60, 255], [40, 160, 90, 255], [60, 90, 200, 128]];
  const bytes = new Uint8Array(4 * TEXELS * TEXELS);
  for (let y = 0; y < TEXELS; y++) {
    for (let x = 0; x < TEXELS; x++) {
      bytes.set(colors[2 * (y >= TEXELS / 2) + (x >= TEXELS / 2)], 4 * (y * TEXELS + x));
    }
  }
  return { width: TEXELS, height: TEXELS, bytes };
}

function png() {
  const { width, height, bytes } = texels();
  const rows = [];
  for (let y = 0; y < height; y++) rows.push(0, ...bytes.subarray(4 * y * width, 4 * (y + 1) * width));
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 6, 0, 0, 0], 8);
  const chunks = [["IHDR", header], ["IDAT", deflateSync(Buffer.from(rows))], ["IEND", Buffer.alloc(0)]];
  return new Uint8Array(Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), ...chunks.map(chunk)]));
}

function chunk([name, data]) {
  const named = Buffer.concat([Buffer.from(name), data]);
  const length = Buffer.alloc(4);
  length.writeUInt32BE(data.length);
  const sum = Buffer.alloc(4);
  sum.writeUInt32BE(crc(named));
  return Buffer.concat([length, named, sum]);
}

function crc(bytes) {
  let sum = ~0;
  for (const byte of bytes) {
    sum ^= byte;
    for (let bit = 0; bit < 8; bit++) sum = sum & 1 ? (sum >>> 1) ^ 0xedb88320 : sum >>> 1;
  }
  return ~sum >>> 0;
}
