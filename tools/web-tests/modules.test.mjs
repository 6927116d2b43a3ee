// Modules of the page that need no browser: links, commands, orbits, and the files that models name.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { fromLink, toCommand, toLink } from '../../apps/web/site/link.js';
import { fetchModel, namedFiles } from '../../apps/web/site/model.js';
import { middle, orbitCamera, parseOrbit } from '../../apps/web/site/orbit.js';

const bytes = (text) => new TextEncoder().encode(text);

test('links say what is seen', () => {
  const view = { camera: { position: [1, 2, 3], target: [0, 0, 0.5], fovDegrees: 40 }, lights: [[1, 2, 3], null, [4, 5, 6.25]] };
  const state = { address: 'demo:gears?triangles=100', duration: 2, seconds: 0.5, heat: 'cells', engine: 'gpu', exposure: -1.5, background: '#102030', view };
  const { camera, lights, seconds, heat, engine, exposure, background, address } = fromLink(toLink(state));
  assert.deepEqual({ camera, lights }, view);
  assert.deepEqual([seconds, heat, engine, exposure, background, address], [0.5, 'cells', 'gpu', -1.5, '#102030', state.address]);
  const plain = fromLink('#scene=demo:a&light=1,2,3&light=0:1,1,1&light=x&exposure=bright&background=red');
  assert.deepEqual([plain.lights, plain.exposure, plain.background], [[[1, 2, 3]], null, 'sky']);
});

test('commands are of the picture that is shown', () => {
  const look = { width: 320, height: 200, samples: 4, bounces: 2, seconds: 1.5, heat: null, engine: 'cpu', background: 'sky', camera: null, lights: [] };
  const camera = { position: [0, 0, 4], target: [0, 0, 0], fovDegrees: 60 };
  const shown = { exposureStops: 0, isWidened: false, camera, lights: [{ spec: 'sun:0,-1,0:3:1,1,1' }, { spec: 'point:1,2,3:4:1,1,1' }] };
  const command = (changes, more = {}) => toCommand({ address: 'demo:gears', duration: 2, look: { ...look, ...changes }, shown: { ...shown, ...more } });
  const plain = 'umbrage render demo:gears --size 320x200 --samples 4 --bounces 2';
  assert.equal(command({}), `${plain} --time 1.5`);
  assert.equal(command({}, { exposureStops: 0.5 }), `${plain} --exposure=0.5 --time 1.5`);
  assert.equal(command({ background: '#102030' }), `${plain} --background '#102030' --time 1.5`);
  assert.equal(command({}, { isWidened: true }), `${plain} --time 1.5 --camera=0,0,4:0,0,0:60`);
  const moved = { lights: [null, [1, 2, 3]] };
  assert.equal(command(moved), `${plain} --time 1.5 --light=sun:0,-1,0:3:1,1,1 --light=point:1,2,3:4:1,1,1`);
  assert.match(command(moved, { lights: [{ spec: null }] }), /--time 1.5  # with the lights where they were$/);
  const file = toCommand({ address: 'my model.glb', duration: 0, look, shown });
  assert.equal(file, "umbrage render 'my model.glb' --size 320x200 --samples 4 --bounces 2 --exposure=0");
});

test('orbits are angles and distances around the scene', () => {
  const near = (a, b) => a.every((value, axis) => Math.abs(value - b[axis]) < 1e-9);
  const shown = { bounds: [[0, 0, 0], [2, 2, 2]], camera: { position: [1, 1, 5], target: [1, 1, 1.5], fovDegrees: 40 } };
  const position = (text) => orbitCamera(parseOrbit(text), shown, middle(shown)).position;
  assert.ok(near(position('0deg 90deg 3m'), [1, 1, 4]));
  assert.ok(near(position('90deg 90deg 300cm'), [4, 1, 1]));
  assert.ok(near(position(`${Math.PI}rad 90deg 50%`), [1, 1, -1]));
  assert.ok(near(position('auto auto 1m'), [1, 1, 2]));
  assert.ok(near(position(null), [1, 1, 5]) && near(position('auto'), [1, 1, 5]));
  // Never quite above it.
  assert.ok(position('0deg 0deg 1m')[2] > 1);
  assert.deepEqual(orbitCamera(parseOrbit('auto'), shown, middle(shown)).target, [1, 1, 1]);
  for (const wrong of ['45', '45deg 1m 1m', '0deg 0deg 0m', '0deg 0deg 1m 1m', '0deg 0deg -1m', 'x']) {
    assert.throws(() => parseOrbit(wrong), /camera-orbit/, wrong);
  }
});

test('models name their files', () => {
  const json = JSON.stringify({ buffers: [{ uri: 'a%20b.bin' }, {}], images: [{ uri: 'data:image/png;base64,AA' }, { uri: 't/x.png' }, { uri: 'https://example.org/y.png' }] });
  assert.deepEqual(namedFiles('m.gltf', bytes(json)), ['a%20b.bin', 't/x.png']);
  const glb = new Uint8Array(20 + json.length);
  glb.set(bytes('glTF'));
  new DataView(glb.buffer).setUint32(12, json.length, true);
  glb.set(bytes(json), 20);
  assert.deepEqual(namedFiles('m.GLB', glb), ['a%20b.bin', 't/x.png']);
  assert.deepEqual(namedFiles('m.obj', bytes('# mtllib no\r\nmtllib my stuff.mtl\r\nv 0 0 0\n')), ['my%20stuff.mtl']);
  const mtl = 'newmtl a\nKd 1 1 1\nmap_Kd -s 2 2 -clamp on t\\wood.png\nbump -bm 0.5 b.png\n';
  assert.deepEqual(namedFiles('m.mtl', bytes(mtl)), ['t/wood.png', 'b.png']);
  assert.deepEqual([namedFiles('m.gltf', bytes('{')), namedFiles('m.stl', bytes('uri'))], [[], []]);
});

test('models are fetched with their files', async () => {
  const files = { '/m/a.obj': 'mtllib a.mtl\n', '/m/a.mtl': 'map_Kd t/x.png\nmap_Ks gone.png\n', '/m/t/x.png': 'png' };
  globalThis.fetch = async (url) => (url.pathname in files ? new Response(files[url.pathname]) : new Response('', { status: 404 }));
  let last = 0;
  const model = await fetchModel(new URL('https://example.org/m/a.obj?v=1'), { onProgress: (loaded) => (last = loaded) });
  assert.deepEqual([model.kind, model.name, model.paths], ['openFiles', 'a.obj', ['a.obj', 'a.mtl', 't/x.png']]);
  assert.equal(await model.files[2].text(), 'png');
  assert.equal(last, Object.values(files).join('').length);
  await assert.rejects(fetchModel(new URL('https://example.org/m/gone.glb')), /gone\.glb: the server answers 404/);
});
