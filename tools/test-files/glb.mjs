// GLB files from their two chunks.

/** A GLB of JSON and of bytes, the JSON's first buffer. */
export function glb(json, binary) {
  const words = JSON.stringify(json);
  const text = Buffer.from(words.padEnd(4 * Math.ceil(Buffer.byteLength(words) / 4)));
  const bytes = Buffer.alloc(4 * Math.ceil(binary.length / 4));
  bytes.set(binary);
  const header = Buffer.from("glTF\x02\0\0\0\0\0\0\0\0\0\0\0JSON", "latin1");
  header.writeUInt32LE(28 + text.length + bytes.length, 8);
  header.writeUInt32LE(text.length, 12);
  const second = Buffer.from("\0\0\0\0BIN\0", "latin1");
  second.writeUInt32LE(bytes.length);
  return Buffer.concat([header, text, second, bytes]);
}
