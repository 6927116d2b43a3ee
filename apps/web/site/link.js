// A view as the part of a link behind `#`, and as a line for a terminal.

// Nine digits are enough to say any number of the engine's.
const number = (value) => Number(value.toPrecision(9));
const numbers = (values) => values.map(number).join(',');

const cameraText = ({ position, target, fovDegrees }) =>
  `${numbers(position)}:${numbers(target)}:${number(fovDegrees)}`;

/** Words of a link that say where lights are: the first one by its position, others with their numbers, from 2. */
const lightWords = (lights) =>
  lights.flatMap((light, index) => (light ? [index === 0 ? numbers(light) : `${index + 1}:${numbers(light)}`] : []));

export function toLink({ address, duration, seconds, heat, engine, exposure, background, view }) {
  const words = new URLSearchParams();
  words.set('scene', address);
  if (duration > 0) words.set('time', Number(seconds.toFixed(3)));
  if (view.camera) words.set('camera', cameraText(view.camera));
  for (const light of lightWords(view.lights)) words.append('light', light);
  if (exposure !== null) words.set('exposure', number(exposure));
  if (background !== 'sky') words.set('background', background.replace('#', ''));
  if (heat) words.set('heat', heat);
  if (engine !== 'cpu') words.set('engine', engine);
  return `#${words.toString().replaceAll('%3A', ':').replaceAll('%2C', ',').replaceAll('%3F', '?').replaceAll('%3D', '=')}`;
}

/** What a link says; what it doesn't, or says wrongly, is left out. */
export function fromLink(hash) {
  // The scene's own options have `=` in them, which is why only the first of a word counts.
  const words = new URLSearchParams(hash.replace(/^#/, ''));
  const vector = (text) => {
    const values = (text ?? '').split(',').map(Number);
    return values.length === 3 && values.every(Number.isFinite) ? values : null;
  };
  const [position, target, fov] = (words.get('camera') ?? '').split(':');
  const isCamera = vector(position) && vector(target) && Number(fov) > 0;
  const seconds = words.has('time') ? Number(words.get('time')) : NaN;
  const exposure = words.has('exposure') ? Number(words.get('exposure')) : NaN;
  const lights = [];
  for (const word of words.getAll('light')) {
    const [, name = '1', light] = word.match(/^(?:(\d{1,3}):)?(.*)$/);
    if (name > 0 && vector(light)) lights[name - 1] = vector(light);
  }
  return {
    address: words.get('scene'),
    seconds: Number.isFinite(seconds) ? Math.max(seconds, 0) : null,
    heat: words.get('heat') ?? '',
    engine: words.get('engine') === 'gpu' ? 'gpu' : 'cpu',
    camera: isCamera ? { position: vector(position), target: vector(target), fovDegrees: Number(fov) } : null,
    lights: Array.from(lights, (light) => light ?? null),
    exposure: Number.isFinite(exposure) ? exposure : null,
    background: /^[0-9a-f]{6}$/i.test(words.get('background') ?? '') ? `#${words.get('background')}` : 'sky',
  };
}

/** The command for the picture that `look` asked for, and that says of itself what is in `shown`. */
export function toCommand({ address, duration, look, shown }) {
  const word = (text) => (/^[\w.:,/=-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
  const { width, height, samples, bounces, seconds, heat, engine, background } = look;
  const isFile = !address.startsWith('demo:');
  const parts = ['umbrage', heat ? 'heatmap' : 'render', word(address), '--size', `${width}x${height}`];
  if (heat) parts.push('--of', heat);
  else parts.push('--samples', samples, '--bounces', bounces);
  // The command measures files anew.
  if (!heat && (isFile || shown.exposureStops !== 0)) parts.push(`--exposure=${number(shown.exposureStops)}`);
  if (!heat && background !== 'sky') parts.push('--background', word(background));
  if (!heat && engine !== 'cpu') parts.push('--engine', engine);
  if (duration > 0) parts.push('--time', Number(seconds.toFixed(3)));
  const camera = look.camera ?? (shown.isWidened ? shown.camera : null);
  if (camera) parts.push(`--camera=${cameraText(camera)}`);
  if (!look.lights.some(Boolean)) return parts.join(' ');
  // The command's lights take the place of all of a scene's.
  if (heat || shown.lights.some(({ spec }) => spec === null)) return `${parts.join(' ')}  # with the lights where they were`;
  return [...parts, ...shown.lights.map(({ spec }) => `--light=${word(spec)}`)].join(' ');
}
