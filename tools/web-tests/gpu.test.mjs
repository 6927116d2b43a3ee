// The page's engine on a GPU, through Dawn, the WebGPU of Chrome, without the rest of a browser. Where Dawn takes none of this
// machine's GPUs it still checks every shader and command, on one that does nothing. It takes Mesa's
// lavapipe 25.0, and refuses 22.3.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { create, globals } from 'webgpu';

const { WEB = '../../target/debug/web', PAGE = '../../target/web' } = process.env;

/** A page's `navigator.gpu`, and whether there is a GPU behind it. */
async function gpu() {
  for (const backend of ['vulkan', 'metal', 'd3d12', 'null']) {
    const found = create([`backend=${backend}`]);
    // Backends that this system doesn't have throw.
    const adapter = await Promise.resolve().then(() => found.requestAdapter()).catch(() => null);
    if (adapter) return { found, isThere: backend !== 'null', name: adapter.info.description };
  }
  throw new Error('Dawn is not even without a GPU');
}

test('a GPU finds the triangles and shadows of this machine\'s processor', { timeout: 900_000 }, async (t) => {
  const { found, isThere, name } = await gpu();
  t.diagnostic(isThere ? `on ${name}` : 'no GPU that Dawn takes: shaders and commands are checked, pictures are not');
  Object.assign(globalThis, globals);
  Object.defineProperty(globalThis, 'navigator', { value: { gpu: found }, configurable: true });
  // What wgpu knows a browser by.
  globalThis.self = globalThis;
  globalThis.Window = class {};
  globalThis.WorkerGlobalScope = Object;
  const { default: init, Page } = await import(pathToFileURL(resolve(PAGE, 'umbrage.js')));
  await init({ module_or_path: readFileSync(resolve(PAGE, 'umbrage_bg.wasm')) });
  const engine = new Page();
  await engine.open_gpu();
  const cases = JSON.parse(execFileSync(WEB, ['proofs']));
  assert.ok(cases.length >= 3);
  for (const { address, look, proof } of cases) {
    engine.open_demo(address);
    const onGpu = JSON.stringify({ ...look, engine: 'gpu' });
    if (!isThere) {
      // What it reads back means nothing, so it may ask for any room; but no command is one that Dawn rejects.
      const why = await engine.render(onGpu).then(() => 'rendered', (error) => error.message);
      assert.match(why, /rendered|needs \d+ bytes|outgrown their buffers/, address);
      continue;
    }
    const shown = JSON.parse(await engine.render(onGpu));
    const stages = shown.stages.map((stage) => stage.name);
    const followed = look.bounces > 0 ? ['nearest', 'meet'] : [];
    for (const stage of ['trace', 'light trace', 'shade', ...followed]) assert.ok(stages.includes(stage), stages.join());
    const { triangles, masks } = JSON.parse(engine.proof());
    const expected = { triangles: proof.triangles, masks: proof.masks, differing: 0 };
    assert.deepEqual({ triangles, masks, differing: await engine.differing(onGpu) }, expected, address);
  }
});
