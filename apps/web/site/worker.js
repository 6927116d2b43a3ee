// The engines, on a thread of their own: the page never waits for them. Orders are answered one after the other, each by one
// message with its number.

import total from './engine-size.js';
import init, { Page } from './umbrage.js';

/** Loads the engine. Messages without a number say how many of its bytes have come. */
async function load() {
  const response = await fetch(new URL('umbrage_bg.wasm', import.meta.url));
  if (!response.ok) throw new Error(`umbrage_bg.wasm: the server answers ${response.status}`);
  let loaded = 0;
  const counted = new TransformStream({
    transform(chunk, controller) {
      loaded += chunk.byteLength;
      postMessage({ progress: { loaded, total } });
      controller.enqueue(chunk);
    },
  });
  const headers = { 'Content-Type': 'application/wasm' };
  await init({ module_or_path: new Response(response.body.pipeThrough(counted), { headers }) });
  return new Page();
}

const page = load();

const answers = {
  gallery: () => ({ gallery: JSON.parse(Page.gallery()) }),
  async openDemo({ address }) {
    return { opened: JSON.parse((await page).open_demo(address)) };
  },
  async openFiles({ name, files, paths = files.map((file) => file.webkitRelativePath || file.name) }) {
    const contents = await Promise.all(files.map(async (file) => new Uint8Array(await file.arrayBuffer())));
    return { opened: JSON.parse((await page).open_files(name, paths, contents)) };
  },
  async render({ look }) {
    const engine = await page;
    const start = performance.now();
    const shown = JSON.parse(await engine.render(JSON.stringify(look)));
    const milliseconds = performance.now() - start;
    return { shown, milliseconds, pixels: engine.pixels() };
  },
  openGpu: async () => ({ name: await (await page).open_gpu() }),
  differing: async ({ look }) => ({ differing: await (await page).differing(JSON.stringify(look)) }),
};

async function answer({ number, kind, ...order }) {
  try {
    await page;
    const answer = await answers[kind](order);
    postMessage({ number, ...answer }, answer.pixels ? [answer.pixels.buffer] : []);
  } catch (error) {
    // An engine that stopped in the middle has no state to go on from.
    const isBroken = error instanceof WebAssembly.RuntimeError || error instanceof WebAssembly.CompileError;
    postMessage({ number, error: String(error.message ?? error), isBroken });
  }
}

// An engine that waits for a GPU must not be asked anything else.
let last = Promise.resolve();
onmessage = ({ data }) => {
  last = last.then(() => answer(data));
};
