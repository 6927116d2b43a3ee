// The page: what is chosen, one order to the engine at a time, and what comes back.

import { Engine } from './engine.js';
import { fromLink, toCommand, toLink } from './link.js';
import { Pace } from './pace.js';
import { View, control } from './view.js';

/** A picture in motion should take no longer, in milliseconds. */
const IN_MOTION = 50;
/** How long nothing must move before a picture gets finer, in milliseconds. */
const PAUSE = 250;
/** The gallery's scenes have no more triangles here unless the link asks for them: phones are slow. */
const TRIANGLES = 100000;
/** Pictures of what stands still: camera rays for each pixel, and how many mirrors light may come by. */
const STEPS = [{ samples: 1, bounces: 0 }, { samples: 4, bounces: 2 }, { samples: 16, bounces: 2 }];
/** Microseconds a pixel that these may take, until they were measured. */
const COSTS = [0.4, 2, 8];
/** A picture in motion has at least so many pixels for one of the page's, along each side. */
const COARSEST = 0.25;

const $ = (id) => document.getElementById(id);
const canvas = $('picture');
const engine = new Engine();
const view = new View();

const state = {
  address: '',
  /** The files of a scene that came from this machine, which the engine needs again after a restart. */
  files: null,
  duration: 0,
  seconds: 0,
  heat: '',
  /** What traces: `cpu` or `gpu`. */
  engine: 'cpu',
  isPlaying: false,
  view,
};
/** What was asked for last, and how it was answered. */
const work = {
  isOpen: false,
  isRendering: false,
  isWanted: false,
  /** Whether the picture is as fine as it gets. */
  isSettled: false,
  /** Which of STEPS the picture is; -1 in motion. */
  step: -1,
  /** When something moved last. */
  moved: 0,
  /** Microseconds a pixel, of each of the steps. */
  costs: [...COSTS],
  /** What pictures in motion take. */
  pace: new Pace(COSTS[0] * 1e-3),
  /** A finer picture that would take longer, in milliseconds, isn't made: the next gesture would wait for it. */
  patience: 4000,
  timer: 0,
  /** Size and time of the last picture, in words. */
  said: '',
  /** What the last picture told of itself. */
  shown: null,
  /** Whether a GPU is open. */
  hasGpu: false,
  /** In how many pixels of the view the GPU and the processor differ; null where that isn't known. */
  differing: null,
};

// For whoever tests the page.
window.umbrage = { state, work };

function say(text) {
  $('status').textContent = text;
}

function complain(error) {
  const [text] = $('trouble').children;
  text.textContent = error.isBroken ? `The engine stopped, maybe for want of memory: ${error.message}` : error.message;
  $('trouble').hidden = false;
}

/** Something moved: a coarse picture is due at once, finer ones once nothing moves any more. */
function changed() {
  work.step = -1;
  work.differing = null;
  work.isSettled = false;
  work.moved = performance.now();
  work.isWanted = true;
  render();
}

/** The size of a picture with so many pixels for one of the page's, along each side. */
function size(factor) {
  const side = (length) => Math.max(Math.round(length * factor), 1);
  return { width: side(canvas.clientWidth), height: side(canvas.clientHeight) };
}

/** More than two pixels for one of the page's aren't seen. */
const whole = () => Math.min(devicePixelRatio, 2);

/** Samples and bounces of one of STEPS: a GPU follows no mirrors here, where the kd-tree is left out. */
const quality = (step) => ({ ...STEPS[step], ...(state.engine === 'gpu' && { bounces: 0 }) });

const finest = () => ({ ...size(whole()), ...quality(STEPS.length - 1) });

/** Size and samples of the picture that is due. */
function plan() {
  if (work.step >= 0) {
    return { ...size(whole()), ...quality(work.step) };
  }
  const { width, height } = size(1);
  const factor = Math.sqrt(work.pace.pixels(IN_MOTION) / (width * height));
  return { ...size(Math.min(Math.max(factor, COARSEST), whole())), ...quality(0) };
}

async function render() {
  if (!work.isOpen || work.isRendering || !work.isWanted) return;
  work.isRendering = true;
  work.isWanted = false;
  const { step } = work;
  const { seconds, engine: by } = state;
  const look = { ...plan(), seconds, camera: view.camera, light: view.light, engine: by, heat: state.heat || null };
  try {
    const answer = await engine.ask('render', { look });
    const pixels = look.width * look.height;
    if (step < 0) work.pace.add(pixels, answer.milliseconds);
    else work.costs[step] = (answer.milliseconds * 1000) / pixels;
    draw(look, answer);
    if (by === 'gpu' && step === 0 && !work.isWanted) await compare(look);
  } catch (error) {
    complain(error);
    if (error.isBroken) {
      work.isOpen = false;
      engine.restart();
    }
    if (by === 'gpu') {
      work.hasGpu = false;
      useCpu();
    }
  }
  work.isRendering = false;
  if (work.isWanted) {
    render();
  } else {
    refineLater();
  }
}

function draw(look, { shown, milliseconds, pixels }) {
  if (canvas.width !== look.width || canvas.height !== look.height) {
    canvas.width = look.width;
    canvas.height = look.height;
  }
  const bytes = new Uint8ClampedArray(pixels.buffer, pixels.byteOffset, pixels.byteLength);
  canvas.getContext('2d').putImageData(new ImageData(bytes, look.width, look.height), 0, 0);
  view.show(shown);
  work.shown = shown;
  const samples = look.samples > 1 ? ` · ${look.samples} samples` : '';
  work.said = `${look.width}×${look.height}${samples} · ${milliseconds.toFixed(0)} ms`;
  sayPicture();
  tell(shown);
}

function sayPicture() {
  const { said, differing } = work;
  say(differing === null ? said : `${said} · ${differing.toLocaleString('en')} pixels differ from the processor's`);
}

/** Has the processor trace the GPU's picture as well. */
async function compare(look) {
  const { differing } = await engine.ask('differing', { look });
  // Another view is due meanwhile, or the processor's picture.
  if (work.isWanted) return;
  work.differing = differing;
  sayPicture();
}

function useCpu() {
  state.engine = $('engine').value = 'cpu';
  forgetCosts();
  changed();
}

/** Other pictures follow, which take other times. */
function forgetCosts() {
  work.costs = [...COSTS];
  work.pace = new Pace(COSTS[0] * 1e-3);
}

/** Has pictures traced by another engine, where there is one. */
async function chooseEngine(name) {
  $('engine').value = name;
  if (name === 'cpu') return useCpu();
  try {
    if (!work.hasGpu) {
      say('Opening the GPU…');
      await engine.ask('openGpu');
      work.hasGpu = true;
    }
    // Somebody may have chosen again.
    if ($('engine').value !== name) return;
    state.engine = name;
    forgetCosts();
    changed();
  } catch (error) {
    complain(new Error(`${error.message}. The processor goes on.`));
    useCpu();
  }
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
  const count = shown.triangles.toLocaleString('en');
  $('facts').textContent = `${count} triangles · ${shown.lights} ${shown.lights === 1 ? 'light' : 'lights'}`;
  $('scale').hidden = !shown.heat;
  if (shown.heat) $('top').textContent = `${shown.heat[1]} ${shown.heat[0]}`;
  $('command').textContent = toCommand({ ...state, ...finest() });
}

/** The next finer picture, once nothing has moved for a while. */
function refineLater() {
  clearTimeout(work.timer);
  const next = work.step + 1;
  if (state.isPlaying || next >= (state.heat ? 1 : STEPS.length)) return settle();
  const { width, height } = size(whole());
  const expected = next > 0 ? work.costs[next] * width * height * 1e-3 : work.pace.of(width * height);
  if (expected > work.patience) return settle();
  const wait = Math.max(work.moved + PAUSE - performance.now(), 0);
  work.timer = setTimeout(() => {
    if (work.isRendering || work.isWanted) return;
    work.step = next;
    work.isWanted = true;
    render();
  }, wait);
}

/** The picture is as fine as it gets: the address says what it shows. */
function settle() {
  work.isSettled = true;
  if (!state.files && !state.isPlaying) history.replaceState(null, '', toLink(state));
}

/** Opens a scene, then shows it as `from` says. */
async function open(order, { address, files = null, from = {} }) {
  work.isOpen = false;
  state.isPlaying = false;
  say(`Opening ${address}…`);
  try {
    const { opened } = await engine.ask(order.kind, order);
    Object.assign(state, { address, files, duration: opened.durationSeconds, seconds: from.seconds ?? opened.stillSeconds });
    forgetCosts();
    view.camera = from.camera ?? null;
    view.light = from.light ?? null;
    choose(address);
    if (opened.warnings.length > 0) complain(new Error(opened.warnings.join('\n')));
  } catch (error) {
    complain(error);
    if (error.isBroken) engine.restart();
    // The last scene is still there, unless there was none.
    if (!state.address || error.isBroken) return say('Nothing is open');
  }
  work.isOpen = true;
  const staysStill = (from.seconds ?? null) !== null || matchMedia('(prefers-reduced-motion: reduce)').matches;
  play(!staysStill);
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

function play(isPlaying) {
  state.isPlaying = isPlaying && state.duration > 0;
  // As links say it.
  if (!state.isPlaying) state.seconds = Number(state.seconds.toFixed(3));
  showTime();
  changed();
  let last = performance.now();
  const step = (now) => {
    if (!state.isPlaying) return;
    // Pictures that take long don't make it slower.
    if (!work.isRendering) {
      state.seconds = (state.seconds + (now - last) / 1000) % state.duration;
      last = now;
      showTime();
      changed();
    }
    requestAnimationFrame(step);
  };
  if (state.isPlaying) requestAnimationFrame(step);
}

control(canvas, view, () => $('move-light').checked, changed);
$('play').addEventListener('click', () => play(!state.isPlaying));
$('time').addEventListener('input', (event) => {
  state.seconds = Number(Number(event.target.value).toFixed(3));
  showTime();
  changed();
});
canvas.addEventListener('keydown', (event) => {
  if (event.code !== 'Space') return;
  event.preventDefault();
  play(!state.isPlaying);
});
$('scene').addEventListener('change', (event) => {
  // What came from files is in that list, too, but only its files can open it.
  if (event.target.value.startsWith('demo:')) openDemo(event.target.value);
  else if (state.files) openFiles(state.files);
});
$('heat').addEventListener('change', (event) => {
  state.heat = event.target.value;
  changed();
});
$('engine').addEventListener('change', (event) => chooseEngine(event.target.value));
$('reset').addEventListener('click', () => {
  view.camera = view.light = null;
  changed();
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
addEventListener('resize', changed);
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
  complain(new Error(`The engine can't be loaded; it needs WebAssembly with SIMD: ${error.message}`));
}
