// The page: the controls around a viewport, and links to its scene.

import { fromLink, toCommand, toLink } from './link.js';
import { megabytes } from './model.js';
import { control } from './view.js';
import { Viewport } from './viewport.js';

/** The gallery's scenes have no more triangles here unless the link asks for them: phones are slow. */
const TRIANGLES = 100000;

const $ = (id) => document.getElementById(id);
const viewport = new Viewport($('picture'), {
  drawn,
  settled,
  compared: sayPicture,
  moved: showTime,
  engine: (name) => ($('engine').value = name),
  failed: complain,
});
const { engine, state, view, work } = viewport;
/** Size and time of the last picture, in words. */
let description = '';

// For tests of the page.
window.umbrage = { state, work };

function say(text) {
  $('status').textContent = text;
}

function complain(error) {
  const [text] = $('trouble').children;
  text.textContent = error.isBroken ? `The engine stopped, maybe for want of memory: ${error.message}` : error.message;
  $('trouble').hidden = false;
}

function drawn({ look, shown, milliseconds }) {
  $('loading').hidden = true;
  const samples = look.samples > 1 ? ` · ${look.samples} samples` : '';
  description = `${look.width}×${look.height}${samples} · ${milliseconds.toFixed(0)} ms`;
  sayPicture();
  tell(shown);
}

function sayPicture() {
  const { differing } = work;
  say(differing === null ? description : `${description} · ${differing.toLocaleString('en')} pixels differ from the processor's`);
}

/** Fills the panel. */
function tell(shown) {
  if ($('panel').hidden) return;
  const all = shown.stages.reduce((sum, stage) => sum + stage.milliseconds, 0) || 1;
  const rows = shown.stages.map(({ name, milliseconds }) => {
    const row = document.createElement('tr');
    for (let cell = 0; cell < 3; cell++) row.insertCell();
    row.cells[0].textContent = name;
    row.cells[1].append(document.createElement('i'));
    row.cells[1].firstChild.style.width = `${(100 * milliseconds) / all}%`;
    row.cells[2].textContent = `${milliseconds.toFixed(1)} ms`;
    return row;
  });
  $('stages').tBodies[0].replaceChildren(...rows);
  const [count, lights] = [shown.triangles.toLocaleString('en'), shown.lights.length];
  $('facts').textContent = `${count} triangles · ${lights} ${lights === 1 ? 'light' : 'lights'}`;
  $('scale').hidden = !shown.heat;
  if (shown.heat) $('top').textContent = `${shown.heat[1]} ${shown.heat[0]}`;
  tellLights(shown.lights);
  $('exposure').value = shown.exposureStops;
  $('stops').textContent = `${shown.exposureStops.toFixed(1)} stops`;
  $('command').textContent = toCommand({ ...state, look: work.look, shown });
}

/** Lists the lights to move. */
function tellLights(lights) {
  const names = lights.map(({ name }, index) => (name ? `Light ${index + 1}: ${name}` : `Light ${index + 1}`));
  const select = $('light');
  if (names.join('\n') !== [...select.options].map((option) => option.text).join('\n')) {
    select.replaceChildren(...names.map((name, index) => new Option(name, index)));
  }
  if (view.chosen >= lights.length) view.chosen = 0;
  select.value = view.chosen;
  select.disabled = $('move-light').disabled = lights.length === 0;
}

/** The picture is as fine as it gets: the address says what it shows. */
function settled() {
  if (!state.files && !state.isPlaying) history.replaceState(null, '', toLink(state));
}

/** Has pictures traced by another engine, where there is one. */
function chooseEngine(name) {
  $('engine').value = name;
  if (name !== 'cpu' && !work.hasGpu) say('Opening the GPU…');
  return viewport.chooseEngine(name);
}

/** Opens a scene, then shows it as the link says. */
async function open(order, whose) {
  say(`Opening ${whose.address}…`);
  try {
    const opened = await viewport.open(order, whose);
    choose(whose.address);
    if (opened.warnings.length > 0) complain(new Error(opened.warnings.join('\n')));
  } catch (error) {
    complain(error);
    // The last scene is still there, unless there was none.
    if (!work.isOpen) return say('Nothing is open');
  }
  showBackground();
  const staysStill = (whose.from?.seconds ?? null) !== null || matchMedia('(prefers-reduced-motion: reduce)').matches;
  viewport.play(!staysStill);
}

const openDemo = (address, from) => open({ kind: 'openDemo', address }, { address, from });

/** Opens the model among some files: the first that a reader knows. */
function openFiles(files) {
  $('trouble').hidden = true;
  const path = (file) => file.webkitRelativePath || file.name;
  const ends = ['.gltf', '.glb', '.pc2', '.mdd', '.obj', '.ply', '.stl'];
  const model = ends.flatMap((end) => files.filter((file) => path(file).toLowerCase().endsWith(end)))[0] ?? files[0];
  if (model) open({ kind: 'openFiles', name: path(model), files }, { address: path(model), files });
}

function choose(address) {
  const select = $('scene');
  let option = [...select.options].find((option) => option.value === address);
  if (!option) {
    select.querySelector('[data-extra]')?.remove();
    option = new Option(address.replace(/^demo:/, ''), address);
    option.dataset.extra = '';
    select.add(option);
  }
  select.value = address;
  $('about').textContent = option.title;
}

function showTime() {
  $('time').max = state.duration || 1;
  $('time').value = state.seconds;
  $('time').disabled = $('play').disabled = state.duration === 0;
  $('play').textContent = state.isPlaying ? '❚❚' : '▶';
  $('play').setAttribute('aria-label', state.isPlaying ? 'Pause' : 'Play');
  $('seconds').textContent = state.duration === 0 ? 'stands still' : `${state.seconds.toFixed(2)} s`;
}

function showBackground() {
  const isSky = state.background === 'sky';
  $('background').value = isSky ? 'sky' : 'colour';
  $('colour').hidden = isSky;
  if (!isSky) $('colour').value = state.background;
}

function chooseBackground(background) {
  state.background = background;
  showBackground();
  viewport.changed();
}

function chooseExposure(stops) {
  state.exposure = stops;
  viewport.changed();
}

control($('picture'), view, (event) => $('move-light').checked || event.shiftKey, () => viewport.changed());
$('play').addEventListener('click', () => viewport.play(!state.isPlaying));
$('time').addEventListener('input', (event) => {
  state.seconds = Number(Number(event.target.value).toFixed(3));
  showTime();
  viewport.changed();
});
$('picture').addEventListener('keydown', (event) => {
  if (event.code !== 'Space') return;
  event.preventDefault();
  viewport.play(!state.isPlaying);
});
$('scene').addEventListener('change', (event) => {
  // A scene of files is in that list, too, but only its files can open it.
  if (event.target.value.startsWith('demo:')) openDemo(event.target.value);
  else if (state.files) openFiles(state.files);
});
$('heat').addEventListener('change', (event) => {
  state.heat = event.target.value;
  viewport.changed();
});
$('engine').addEventListener('change', (event) => chooseEngine(event.target.value));
$('light').addEventListener('change', (event) => (view.chosen = Number(event.target.value)));
$('exposure').addEventListener('input', (event) => chooseExposure(Number(event.target.value)));
$('metered').addEventListener('click', () => chooseExposure(null));
$('background').addEventListener('change', (event) => chooseBackground(event.target.value === 'sky' ? 'sky' : $('colour').value));
$('colour').addEventListener('input', (event) => chooseBackground(event.target.value));
$('reset').addEventListener('click', () => {
  view.camera = null;
  view.lights = [];
  viewport.changed();
});
$('more').addEventListener('click', () => {
  $('panel').hidden = !$('panel').hidden;
  $('more').setAttribute('aria-expanded', !$('panel').hidden);
  if (work.shown) tell(work.shown);
});
$('share').addEventListener('click', async () => {
  if (state.files) return complain(new Error('A link can show scenes of the gallery; your file stays on this machine.'));
  const link = new URL(toLink(state), location.href).href;
  history.replaceState(null, '', link);
  try {
    await navigator.clipboard.writeText(link);
    say('The link is copied');
  } catch {
    say('The link is in the address bar');
  }
});
$('open').addEventListener('click', () => $('files').click());
$('files').addEventListener('change', (event) => openFiles([...event.target.files]));
$('trouble').querySelector('button').addEventListener('click', () => ($('trouble').hidden = true));
addEventListener('dragover', (event) => {
  event.preventDefault();
  $('drop').hidden = false;
});
addEventListener('dragleave', (event) => ($('drop').hidden = event.relatedTarget === null));
addEventListener('drop', (event) => {
  event.preventDefault();
  $('drop').hidden = true;
  openFiles([...event.dataTransfer.files]);
});
addEventListener('hashchange', () => start(fromLink(location.hash)));

/** Shows what a link says. */
function start(from) {
  state.heat = [...$('heat').options].some((option) => option.value === from.heat) ? from.heat : '';
  $('heat').value = state.heat;
  if (from.engine !== state.engine) chooseEngine(from.engine);
  const known = from.address?.startsWith('demo:') ? from.address : $('scene').options[1].value;
  return openDemo(known, from);
}

engine.onprogress = ({ loaded, total }) => {
  $('loaded').value = loaded / total;
  $('bytes').textContent = `Loading the engine: ${megabytes(loaded)} of ${megabytes(total)}`;
};
try {
  const { gallery } = await engine.ask('gallery');
  for (const { name, about, triangles } of gallery) {
    const address = triangles > TRIANGLES ? `demo:${name}?triangles=${TRIANGLES}` : `demo:${name}`;
    const option = new Option(name, address);
    option.title = about;
    $('scene').add(option);
  }
  await start(fromLink(location.hash));
} catch (error) {
  say('');
  $('loading').hidden = true;
  complain(new Error(`The engine can't be loaded; it needs WebAssembly with SIMD: ${error.message}`));
}
