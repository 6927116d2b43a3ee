// The engine, on a thread of its own: the page never waits for it. Each order is answered by one message with its number.

import init, { Page } from './umbrage.js';

const page = init().then(() => new Page());

const answers = {
  gallery: () => ({ gallery: JSON.parse(Page.gallery()) }),
  async openDemo({ address }) {
    return { opened: JSON.parse((await page).open_demo(address)) };
  },
  async openFiles({ name, files }) {
    const contents = await Promise.all(files.map(async (file) => new Uint8Array(await file.arrayBuffer())));
    const paths = files.map((file) => file.webkitRelativePath || file.name);
    return { opened: JSON.parse((await page).open_files(name, paths, contents)) };
  },
  async render({ look }) {
    const engine = await page;
    const start = performance.now();
    const shown = JSON.parse(engine.render(JSON.stringify(look)));
    const milliseconds = performance.now() - start;
    return { shown, milliseconds, pixels: engine.pixels() };
  },
};

onmessage = async ({ data: { number, kind, ...order } }) => {
  try {
    await page;
    const answer = await answers[kind](order);
    postMessage({ number, ...answer }, answer.pixels ? [answer.pixels.buffer] : []);
  } catch (error) {
    // What stops the engine in the middle leaves it in no state to go on from.
    const isBroken = error instanceof WebAssembly.RuntimeError || error instanceof WebAssembly.CompileError;
    postMessage({ number, error: String(error.message ?? error), isBroken });
  }
};
