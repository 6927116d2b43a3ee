// Writes one picture as AVIF in the ways that sharp has, to the fuzzer's corpus, where tests find it.

import sharp from "sharp";
import { fileURLToPath } from "node:url";

const FOLDER = new URL("../../crates/verify/corpus/images/", import.meta.url);
const [width, height] = [21, 13];

const bytes = Buffer.alloc(4 * width * height);
for (let y = 0; y < height; y++) {
  for (let x = 0; x < width; x++) {
    bytes.set([40 + 8 * x, 200 - 9 * y, 60 + 4 * x + 5 * y, 255 - 10 * y], 4 * (y * width + x));
  }
}
const picture = sharp(bytes, { raw: { width, height, channels: 4 } });
const best = { quality: 100, effort: 4 };

const pictures = {
  "420.avif": picture.clone().avif({ ...best, chromaSubsampling: "4:2:0" }),
  "444-10.avif": picture.clone().avif({ ...best, bitdepth: 10, chromaSubsampling: "4:4:4" }),
  "420-12.avif": picture.clone().removeAlpha().avif({ ...best, bitdepth: 12, chromaSubsampling: "4:2:0" }),
};
for (const [name, made] of Object.entries(pictures)) {
  await made.toFile(fileURLToPath(new URL(name, FOLDER)));
}
