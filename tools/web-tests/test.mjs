// The page in headless Chromium: `cargo run -p web -- build`, then `npm ci` and `npm test` here. `WEB` is the program that
// serves it, `PAGE` the folder where it is, `CHROMIUM` the browser; `SHOTS` is a folder that keeps screenshots to look at.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { SHOTS, WAIT, WEB, launch } from './browser.mjs';

let browser;
let address;
let close;

before(async () => ({ browser, address, close } = await launch()));
after(() => close?.());

/** A page on which everything that goes wrong is kept in `errors`. */
async function open(hash = '', options = {}) {
  const context = await browser.newContext({ viewport: { width: 800, height: 500 }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(WAIT);
  const errors = [];
  page.on('pageerror', (error) => errors.push(error.message));
  page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
  await page.goto(`${address}/index.html${hash}`);
  await page.waitForFunction(() => window.umbrage);
  // However busy the machine is.
  await page.evaluate(() => (umbrage.work.patience = Infinity));
  return { page, errors, context };
}

/** Once the picture is as fine as it gets. */
const settled = (page) =>
  page.waitForFunction(() => umbrage.work.isOpen && umbrage.work.isSettled && !umbrage.work.isRendering, null, { polling: 50 });

async function shot(page, name) {
  if (SHOTS) await page.screenshot({ path: join(SHOTS, `${name}.png`) });
}

/** How many different colours the canvas shows. */
const colors = (page) =>
  page.evaluate(() => {
    const canvas = document.getElementById('picture');
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  });

test('pictures are those of this machine, bit for bit', async () => {
  const cases = JSON.parse(execFileSync(WEB, ['proofs']));
  assert.ok(cases.length >= 3);
  const { page, context } = await open();
  for (const { address, look, proof } of cases) {
    const found = await page.evaluate(
      async ([address, look]) => {
        const { default: init, Page } = await import('./umbrage.js');
        await init();
        const engine = new Page();
        engine.open_demo(address);
        await engine.render(JSON.stringify(look));
        return JSON.parse(engine.proof());
      },
      [address, look],
    );
    assert.deepEqual(found, proof, address);
  }
  await context.close();
});

test('without a GPU the page says so and the processor goes on', async () => {
  const { page, errors, context } = await open('#scene=demo:gears?triangles=2000&time=0&engine=gpu');
  await page.waitForSelector('#trouble:not([hidden])');
  assert.match(await page.textContent('#trouble p'), /no GPU adapter.*The processor goes on/);
  await settled(page);
  assert.equal(await page.evaluate(() => umbrage.state.engine), 'cpu');
  assert.ok((await colors(page)) > 100);
  assert.deepEqual(errors, []);
  await context.close();
});

test('a scene is shown, gone round and linked to', async () => {
  const { page, errors, context } = await open('#scene=demo:gears?triangles=3000&time=0.5');
  await settled(page);
  assert.ok((await colors(page)) > 100);
  const first = page.url();
  assert.match(first, /scene=demo:gears\?triangles=3000/);
  assert.match(first, /time=0\.5/);
  assert.doesNotMatch(first, /camera/);
  await page.mouse.move(320, 200);
  await page.mouse.down();
  await page.mouse.move(400, 180, { steps: 4 });
  await page.mouse.up();
  await page.mouse.wheel(0, -200);
  await page.waitForFunction((first) => location.href !== first, first);
  await settled(page);
  const link = page.url();
  assert.match(link, /camera=/);
  const pixels = () => page.evaluate(() => document.getElementById('picture').toDataURL());
  const moved = await pixels();
  await context.close();

  // The link shows the same.
  const other = await open(new URL(link).hash);
  await settled(other.page);
  const same = await other.page.evaluate(() => document.getElementById('picture').toDataURL());
  assert.ok(same === moved, 'the link shows another picture');
  assert.equal(other.page.url(), link);
  assert.deepEqual([...errors, ...other.errors], []);
  await other.context.close();
});

test('the engine\'s bytes are counted while it is loaded', async () => {
  const { page, errors, context } = await open('#scene=demo:gears?triangles=2000&time=0');
  await settled(page);
  const [, loaded, total] = (await page.textContent('#bytes')).match(/^Loading the engine: ([\d.]+) MB of ([\d.]+) MB$/) ?? [];
  assert.ok(Number.parseFloat(total) > 1 && loaded === total, `${loaded} of ${total}`);
  assert.equal(await page.isHidden('#loading'), true);
  assert.deepEqual(errors, []);
  await context.close();
});

test('exposure and background are chosen and linked to', async () => {
  const { page, errors, context } = await open('#scene=demo:statue?triangles=2000&time=0');
  await settled(page);
  await page.click('#more');
  const corner = () => page.evaluate(() => [...document.getElementById('picture').getContext('2d').getImageData(0, 0, 1, 1).data]);
  const sum = () =>
    page.evaluate(() => {
      const canvas = document.getElementById('picture');
      return canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.reduce((sum, level) => sum + level, 0);
    });
  await settled(page);
  const bright = await sum();
  await page.fill('#exposure', '-2');
  await page.waitForFunction(() => location.href.includes('exposure=-2'));
  assert.ok((await sum()) < bright, 'two stops less are not darker');
  assert.match(await page.textContent('#command'), / --exposure=-2( |$)/);
  await page.selectOption('#background', 'colour');
  await page.fill('#colour', '#3050ff');
  await page.waitForFunction(() => location.href.includes('background=3050ff'));
  assert.match(await page.textContent('#command'), / --background '#3050ff'/);
  const link = new URL(page.url()).hash;
  const shown = await corner();
  await page.click('#metered');
  await page.waitForFunction(() => !location.href.includes('exposure'));
  assert.deepEqual(errors, []);
  await context.close();

  const other = await open(link);
  await settled(other.page);
  const { exposure, background } = await other.page.evaluate(() => umbrage.state);
  assert.deepEqual({ exposure, background }, { exposure: -2, background: '#3050ff' });
  const again = await other.page.evaluate(() => [...document.getElementById('picture').getContext('2d').getImageData(0, 0, 1, 1).data]);
  // The ground or the sky's colour, by the camera; the panel has changed the picture's proportions.
  assert.equal(again.length, shown.length);
  await other.context.close();
});

test('the lights move, heat maps and times are shown', async () => {
  const { page, errors, context } = await open('#scene=demo:marbles?triangles=5000&time=2');
  await settled(page);
  await page.click('#more');
  await page.waitForSelector('#stages tr');
  const names = await page.$$eval('#stages td:first-child', (cells) => cells.map((cell) => cell.textContent));
  for (const stage of ['animate', 'build', 'see', 'shadow', 'shade', 'develop']) assert.ok(names.includes(stage), names.join());
  await page.check('#move-light');
  await page.mouse.move(100, 200);
  await page.mouse.down();
  await page.mouse.move(160, 200, { steps: 3 });
  await page.mouse.up();
  await page.waitForFunction(() => location.href.includes('light='));
  // The second one as well.
  await page.selectOption('#light', '1');
  await page.mouse.move(100, 200);
  await page.mouse.down();
  await page.mouse.move(60, 180, { steps: 3 });
  await page.mouse.up();
  await page.waitForFunction(() => location.href.includes('light=2:'));
  const [lights, samples] = await page.evaluate(() => [umbrage.work.shown.lights.length, umbrage.work.look.samples]);
  const command = await page.textContent('#command');
  assert.equal(command.match(/ --light=\w+:/g)?.length, lights, command);
  assert.ok(command.includes(` --samples ${samples} `), command);
  await page.selectOption('#heat', 'tested');
  await page.waitForFunction(() => location.href.includes('heat=tested'));
  await page.waitForSelector('#scale:not([hidden])');
  assert.match(await page.textContent('#top'), /triangles tested/);
  assert.match(await page.textContent('#command'), /^umbrage heatmap 'demo:marbles\?triangles=5000' --size \d+x\d+ --of tested/);
  await shot(page, 'heat');
  assert.deepEqual(errors, []);
  await context.close();
});

test('files of this machine are opened, and broken ones are errors after which all goes on', async () => {
  const { page, errors, context } = await open('#scene=demo:gears?triangles=2000&time=0');
  await settled(page);
  const file = (name, text) => ({ name, mimeType: '', buffer: Buffer.from(text) });
  await page.setInputFiles('#files', [file('broken.glb', 'glTF and then nothing of the kind')]);
  await page.waitForSelector('#trouble:not([hidden])');
  assert.match(await page.textContent('#trouble p'), /broken\.glb/);
  await shot(page, 'broken');
  await page.setInputFiles('#files', [
    file('square.mtl', 'newmtl red\nKd 1 0 0\n'),
    file('square.obj', 'mtllib square.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n'),
  ]);
  await page.waitForFunction(() => umbrage.state.address === 'square.obj' && umbrage.work.isSettled);
  await settled(page);
  assert.equal(await page.isHidden('#trouble'), true);
  const red = await page.evaluate(() => {
    const canvas = document.getElementById('picture');
    return [...canvas.getContext('2d').getImageData(canvas.width / 2, canvas.height / 2, 1, 1).data];
  });
  assert.ok(red[0] > 60 && red[0] > 3 * red[1], `the square is red: ${red}`);
  assert.deepEqual(errors, []);
  await context.close();
});

test('demos play at once, and stay as large as they can be seen', async () => {
  const link = (name) => `#scene=demo:${name}?triangles=20000`;
  const { page, errors, context } = await open(link('cloth'));
  for (const name of ['cloth', 'forest', 'hall', 'gears', 'marbles']) {
    await page.evaluate((hash) => (location.hash = hash), link(name));
    await page.waitForFunction(
      (name) => umbrage.state.address.includes(name) && umbrage.work.isOpen && umbrage.state.isPlaying && umbrage.work.shown,
      name,
    );
    const start = await page.evaluate(() => umbrage.state.seconds);
    assert.ok(start > 1, `${name} starts at ${start} s, where there is nothing to see`);
    const pictures = await page.evaluate(async () => {
      const seen = new Set();
      const end = performance.now() + 3000;
      while (performance.now() < end) {
        seen.add(umbrage.state.seconds);
        await new Promise(requestAnimationFrame);
      }
      return seen.size;
    });
    const factor = await page.evaluate(() => {
      const canvas = document.getElementById('picture');
      return canvas.width / canvas.clientWidth;
    });
    await shot(page, `playing-${name}`);
    assert.ok(factor > 0.24, `${name} has shrunk to ${factor}`);
    assert.ok(pictures > 3, `${name} shows ${pictures} moments in three seconds`);
  }
  await page.click('#play');
  await settled(page);
  assert.deepEqual(errors, []);
  await context.close();
});

test('desktops and phones show the page whole', async () => {
  for (const [name, options] of [
    ['desktop', { viewport: { width: 1280, height: 800 } }],
    ['small', { viewport: { width: 800, height: 600 } }],
    ['phone', { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true }],
  ]) {
    const { page, errors, context } = await open('#scene=demo:cloth?triangles=20000&time=1', options);
    await settled(page);
    await page.click('#more');
    await page.waitForSelector('#stages tr');
    await settled(page);
    await shot(page, name);
    const [panel, picture] = [await page.locator('#panel').boundingBox(), await page.locator('#picture').boundingBox()];
    const isBeside = panel.x >= picture.x + picture.width || panel.y >= picture.y + picture.height;
    assert.ok(isBeside && picture.width * picture.height > panel.width * panel.height, `${name}: the panel covers the picture`);
    await page.click('#more');
    await shot(page, `${name}-without-details`);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${name}: ${wide} pixels too wide`);
    for (const id of ['scene', 'open', 'share', 'more', 'play', 'time']) {
      const { x, y, width, height } = await page.locator(`#${id}`).boundingBox();
      const view = page.viewportSize();
      assert.ok(x >= 0 && y >= 0 && x + width <= view.width && y + height <= view.height, `${name}: ${id} is cut off`);
    }
    assert.deepEqual(errors, []);
    await context.close();
  }
});

test('memory stays as it is over 500 frames', async () => {
  const { page, context } = await open();
  const bytes = await page.evaluate(async () => {
    const { default: init, Page } = await import('./umbrage.js');
    const { memory } = await init();
    const engine = new Page();
    engine.open_demo('demo:marbles?triangles=2000');
    const look = { width: 64, height: 48 };
    const bytes = [];
    for (let frame = 0; frame < 600; frame++) {
      await engine.render(JSON.stringify({ ...look, seconds: (frame % 50) / 25 }));
      engine.pixels();
      bytes.push(memory.buffer.byteLength);
    }
    return bytes;
  });
  assert.equal(bytes[599], bytes[99], 'the engine takes more memory with every frame');
  await context.close();
});
