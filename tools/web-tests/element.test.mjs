// `<umbrage-viewer>` in a page of somebody else, in headless Chromium, after what test.mjs needs.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { SHOTS, WAIT, launch } from './browser.mjs';

let browser;
let address;
let close;

before(async () => ({ browser, address, close } = await launch()));
after(() => close?.());

/** A glTF file of a red triangle, with its positions in a file of its own. */
const GLTF = {
  asset: { version: '2.0' },
  scene: 0,
  scenes: [{ nodes: [0] }],
  nodes: [{ mesh: 0 }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0 }, material: 0 }] }],
  materials: [{ doubleSided: true, pbrMetallicRoughness: { baseColorFactor: [1, 0, 0, 1], metallicFactor: 0 } }],
  accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [-1, -1, 0], max: [1, 1, 0] }],
  bufferViews: [{ buffer: 0, byteLength: 36 }],
  buffers: [{ uri: 'a%20b.bin', byteLength: 36 }],
};
const FILES = {
  'models/red.gltf': JSON.stringify(GLTF),
  'models/a%20b.bin': Buffer.from(new Float32Array([-1, -1, 0, 1, -1, 0, 0, 1, 0]).buffer),
  'poster.svg': '<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"><rect width="8" height="8"/></svg>',
};

/** A page with this body. Events of its elements are in `told`, the names of all that its window has before in `names`. */
async function open(body) {
  const context = await browser.newContext({ viewport: { width: 640, height: 400 } });
  const page = await context.newPage();
  page.setDefaultTimeout(WAIT);
  const errors = [];
  page.on('pageerror', (error) => errors.push(error.message));
  for (const [path, content] of Object.entries(FILES)) {
    const contentType = path.endsWith('.svg') ? 'image/svg+xml' : 'application/octet-stream';
    await page.route(`${address}/${path}`, (route) => route.fulfill({ contentType, body: content }));
  }
  const html = `<!doctype html><style>umbrage-viewer { width: 300px; height: 200px }</style>
    <script>
      const told = [];
      for (const name of ['load', 'error', 'progress']) {
        // A window isn't told of its elements' load.
        document.addEventListener(name, ({ target, detail }) => target.localName === 'umbrage-viewer' && told.push({ name, id: target.id, ...detail }), true);
      }
      const names = new Set(Object.getOwnPropertyNames(window));
    </script>
    <script type="module" src="umbrage-viewer.js"></script>${body}`;
  await page.route(`${address}/host.html`, (route) => route.fulfill({ contentType: 'text/html', body: html }));
  await page.goto(`${address}/host.html`);
  return { page, errors, context };
}

const loaded = (page, id) => page.waitForFunction((id) => told.some(({ name, id: of }) => name === 'load' && of === id), id);

/** The picture of an element, once it stays. */
async function picture(page, id) {
  let last;
  for (;;) {
    const next = await page.evaluate((id) => document.getElementById(id).shadowRoot.querySelector('canvas').toDataURL(), id);
    if (next === last) return next;
    last = next;
    await page.waitForTimeout(1000);
  }
}

/** How many of an element's pixels are red, in a hundred. */
const red = (page, id) =>
  page.evaluate((id) => {
    const canvas = document.getElementById(id).shadowRoot.querySelector('canvas');
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let pixel = 0; pixel < data.length; pixel += 4) count += data[pixel] > 2 * data[pixel + 1] + 20 ? 1 : 0;
    return (400 * count) / data.length;
  }, id);

test('two elements of a page show their scenes', async () => {
  const { page, errors, context } = await open(`
    <umbrage-viewer id="model" src="models/red.gltf" camera-orbit="0deg 90deg 5m" poster="poster.svg" alt="A red triangle"></umbrage-viewer>
    <umbrage-viewer id="demo" src="demo:gears?triangles=2000"></umbrage-viewer>`);
  await loaded(page, 'model');
  await loaded(page, 'demo');
  const told = await page.evaluate(() => told);
  for (const id of ['model', 'demo']) {
    const shares = told.filter((event) => event.name === 'progress' && event.id === id).map(({ totalProgress }) => totalProgress);
    assert.ok(shares.every((share, index) => index === 0 || share >= shares[index - 1]) && shares.at(-1) === 1, shares.join());
  }
  assert.deepEqual(told.filter(({ name }) => name === 'error'), []);
  const parts = await page.evaluate(() => {
    const { shadowRoot: root, loaded } = document.getElementById('model');
    return [loaded, root.querySelector('img').hidden, root.querySelector('progress').hidden, root.querySelector('canvas').ariaLabel];
  });
  assert.deepEqual(parts, [true, true, true, 'A red triangle']);
  const added = await page.evaluate(() => Object.getOwnPropertyNames(window).filter((name) => !names.has(name)));
  assert.deepEqual(added, []);

  const front = await picture(page, 'model');
  const share = await red(page, 'model');
  assert.ok(share > 5 && share < 50, `${share} in a hundred are red`);
  if (SHOTS) await page.screenshot({ path: join(SHOTS, 'elements.png') });
  // Nearer, it is larger; from the side, a triangle can't be seen.
  await page.evaluate(() => document.getElementById('model').setAttribute('camera-orbit', '0deg 90deg 4m'));
  assert.notEqual(await picture(page, 'model'), front);
  assert.ok((await red(page, 'model')) > 1.2 * share);
  await page.evaluate(() => document.getElementById('model').setAttribute('camera-orbit', '90deg 90deg 5m'));
  await picture(page, 'model');
  assert.ok((await red(page, 'model')) < 1);
  const before = await picture(page, 'demo');
  await page.evaluate(() => document.getElementById('demo').setAttribute('exposure', '0.25'));
  assert.notEqual(await picture(page, 'demo'), before);
  assert.deepEqual(errors, []);
  await context.close();
});

test('broken addresses are errors, and other ones after them are shown', async () => {
  const { page, errors, context } = await open('<umbrage-viewer id="a" src="gone.glb" poster="poster.svg"></umbrage-viewer>');
  await page.waitForFunction(() => told.some(({ name }) => name === 'error'));
  assert.match(await page.evaluate(() => told.find(({ name }) => name === 'error').sourceError.message), /gone\.glb.*404/);
  assert.equal(await page.evaluate(() => document.getElementById('a').shadowRoot.querySelector('img').hidden), false);
  await page.evaluate(() => (document.getElementById('a').setAttribute('src', 'models/red.gltf')));
  await loaded(page, 'a');
  assert.equal(await page.evaluate(() => document.getElementById('a').shadowRoot.querySelector('p').hidden), true);
  // Removed and put back, it shows its scene again.
  await page.evaluate(() => {
    const element = document.getElementById('a');
    told.length = 0;
    element.remove();
    document.body.append(element);
  });
  await loaded(page, 'a');
  assert.deepEqual(errors, []);
  await context.close();
});

test('elements turn, and gestures move them where they may', async () => {
  const { page, errors, context } = await open(`
    <umbrage-viewer id="still" src="models/red.gltf"></umbrage-viewer>
    <umbrage-viewer id="moved" src="models/red.gltf" camera-controls></umbrage-viewer>
    <umbrage-viewer id="turning" src="models/red.gltf" auto-rotate></umbrage-viewer>`);
  for (const id of ['still', 'moved', 'turning']) await loaded(page, id);
  const look = (id) => page.evaluate((id) => document.getElementById(id).shadowRoot.querySelector('canvas').toDataURL(), id);
  const turning = await look('turning');
  const before = { still: await picture(page, 'still'), moved: await picture(page, 'moved') };
  for (const id of ['still', 'moved']) {
    const { x, y } = await page.locator(`#${id}`).boundingBox();
    await page.mouse.move(x + 150, y + 100);
    await page.mouse.down();
    await page.mouse.move(x + 200, y + 100, { steps: 3 });
    await page.mouse.up();
  }
  assert.equal(await picture(page, 'still'), before.still);
  assert.notEqual(await picture(page, 'moved'), before.moved);
  assert.notEqual(await look('turning'), turning);
  assert.deepEqual(errors, []);
  await context.close();
});

test('the example shows its elements', async () => {
  const context = await browser.newContext({ viewport: { width: 900, height: 1100 } });
  const page = await context.newPage();
  page.setDefaultTimeout(WAIT);
  const errors = [];
  page.on('pageerror', (error) => errors.push(error.message));
  await page.goto(`${address}/element.html`);
  await page.waitForFunction(() => [...document.querySelectorAll('umbrage-viewer')].every(({ loaded }) => loaded));
  if (SHOTS) await page.screenshot({ path: join(SHOTS, 'example.png') });
  assert.deepEqual(errors, []);
  await context.close();
});
