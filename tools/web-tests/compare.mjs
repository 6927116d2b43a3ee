// How fast the page's engine is beside three-mesh-bvh, in the same browser: `node compare.mjs`, after what test.mjs needs.
//
// Each frame of a deforming mesh, both have the same triangles and the same rays through the middles of pixels. three-mesh-bvh
// builds its hierarchy anew, by its default strategy and by surface areas, then finds each ray's first hit; or fits the
// first frame's boxes to the moved vertices instead. The page's engine makes its grid and answers the rays. Both have one
// thread. Times are medians of frames, in milliseconds; rays on whose hit they differ are counted.

import { spawn } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { chromium } from 'playwright-core';

const { WEB = '../../target/debug/web', PAGE = '../../target/web', CHROMIUM = '/usr/bin/chromium' } = process.env;
const MODULES = join(import.meta.dirname, 'node_modules');
const SCENES = ['demo:cloth?triangles=100000', 'demo:statue?triangles=100000', 'demo:shatter?triangles=100000'];

const HTML = `<!doctype html><script type="importmap">{"imports": {
  "three": "/modules/three/build/three.module.js", "three-mesh-bvh": "/modules/three-mesh-bvh/build/index.module.js"}}</script>`;

/** Runs in the page. */
async function measure([address, width, height]) {
  const THREE = await import('three');
  const { MeshBVH, SAH, CENTER } = await import('three-mesh-bvh');
  const { default: init, Page } = await import('/umbrage.js');
  await init();
  const engine = new Page();
  engine.open_demo(address);
  const FRAMES = 7;
  const times = {};
  const add = (name, milliseconds) => (times[name] ??= []).push(milliseconds);
  let differing = 0;
  let triangles;
  let refitted;
  for (let frame = 0; frame < FRAMES; frame++) {
    const look = { width, height, seconds: 0.8 + frame / 24 };
    const shown = JSON.parse(await engine.render(JSON.stringify(look)));
    const stage = (name) => shown.stages.find((stage) => stage.name === name).milliseconds;
    // The first frames group triangles.
    if (frame >= 2) add('Umbrage', stage('build') + stage('see'));
    triangles = shown.triangles;
    const corners = engine.triangles();
    const geometry = () => {
      const made = new THREE.BufferGeometry();
      made.setAttribute('position', new THREE.BufferAttribute(corners.slice(), 3));
      return made;
    };

    const { position, target, fovDegrees } = shown.camera;
    const camera = new THREE.PerspectiveCamera(fovDegrees, width / height, 0.1, 1000);
    camera.position.set(...position);
    camera.lookAt(...target);
    camera.updateMatrixWorld();
    const axes = [0, 1, 2].map((axis) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, axis));
    const half = Math.tan((fovDegrees * Math.PI) / 360);
    const trace = (bvh) => {
      const ray = new THREE.Ray(camera.position.clone(), new THREE.Vector3());
      const seen = new Uint8Array(width * height);
      for (let y = 0; y < height; y++) {
        for (let x = 0; x < width; x++) {
          const right = (2 * (x + 0.5) - width) * (half / height);
          const up = (height - 2 * (y + 0.5)) * (half / height);
          ray.direction.copy(axes[2]).multiplyScalar(-1).addScaledVector(axes[0], right).addScaledVector(axes[1], up);
          ray.direction.normalize();
          seen[y * width + x] = bvh.raycastFirst(ray, THREE.DoubleSide) ? 1 : 0;
        }
      }
      return seen;
    };
    for (const [name, strategy] of [['three-mesh-bvh, rebuilt', CENTER], ['three-mesh-bvh, rebuilt by areas', SAH]]) {
      const mesh = geometry();
      const start = performance.now();
      const bvh = new MeshBVH(mesh, { strategy });
      const built = performance.now();
      const seen = trace(bvh);
      if (frame >= 2) {
        add(name, performance.now() - start);
        add(`${name}: building alone`, built - start);
      }
      if (strategy === SAH) {
        refitted ??= new MeshBVH(geometry(), { strategy });
        const hits = engine.hits();
        for (let pixel = 0; pixel < hits.length; pixel++) differing += (hits[pixel] !== 0xffffffff) !== (seen[pixel] === 1);
      }
    }
    // The hierarchy sorts an index of its own: vertices stay where they are.
    refitted.geometry.attributes.position.array.set(corners);
    const start = performance.now();
    refitted.refit();
    trace(refitted);
    if (frame >= 2) add('three-mesh-bvh, refitted', performance.now() - start);
  }
  const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
  return { triangles, differing, times: Object.fromEntries(Object.entries(times).map(([name, list]) => [name, median(list)])) };
}

const server = spawn(WEB, ['serve', '--built', PAGE, '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
let address;
for await (const line of createInterface({ input: server.stdout })) {
  address = line.match(/http:\S+/)[0];
  break;
}
const browser = await chromium.launch({ executablePath: CHROMIUM, args: ['--no-sandbox', '--disable-gpu'] });
const page = await browser.newPage();
await page.route('**/compare.html', (route) => route.fulfill({ contentType: 'text/html', body: HTML }));
await page.route('**/modules/**', async (route) => {
  const path = new URL(route.request().url()).pathname.replace('/modules/', '');
  await route.fulfill({ contentType: 'text/javascript', body: await readFile(join(MODULES, path)) });
});
await page.goto(`${address}/compare.html`);
for (const scene of process.argv.length > 2 ? process.argv.slice(2) : SCENES) {
  const { triangles, differing, times } = await page.evaluate(measure, [scene, 640, 360]);
  console.log(`${scene}: ${triangles} triangles, 640×360 rays a frame; ${differing} of all frames' rays differ in whether they hit`);
  for (const [name, milliseconds] of Object.entries(times)) {
    const ratio = name === 'Umbrage' ? '' : `  ${(milliseconds / times.Umbrage).toFixed(1)} times as long`;
    console.log(`  ${name.padEnd(50)} ${milliseconds.toFixed(1).padStart(9)} ms${ratio}`);
  }
}
await browser.close();
server.kill();
