// A view as the part of a link behind `#`, and as a line for a terminal.

// Nine digits are enough to say any number of the engine's.
const number = (value) => Number(value.toPrecision(9));
const numbers = (values) => values.map(number).join(',');

const cameraText = ({ position, target, fovDegrees }) =>
  `${numbers(position)}:${numbers(target)}:${number(fovDegrees)}`;

export function toLink({ address, duration, seconds, heat, engine, view }) {
  const words = new URLSearchParams();
  words.set('scene', address);
  if (duration > 0) words.set('time', Number(seconds.toFixed(3)));
  if (view.camera) words.set('camera', cameraText(view.camera));
  if (view.light) words.set('light', numbers(view.light));
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
  return {
    address: words.get('scene'),
    seconds: Number.isFinite(seconds) ? Math.max(seconds, 0) : null,
    heat: words.get('heat') ?? '',
    engine: words.get('engine') === 'gpu' ? 'gpu' : 'cpu',
    camera: isCamera ? { position: vector(position), target: vector(target), fovDegrees: Number(fov) } : null,
    light: vector(words.get('light')),
  };
}

export function toCommand({ address, duration, seconds, heat, engine, view, width, height, samples, bounces }) {
  const word = (text) => (/^[\w.:,/=-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
  const parts = ['umbrage', heat ? 'heatmap' : 'render', word(address)];
  parts.push('--size', `${width}x${height}`);
  if (heat) parts.push('--of', heat);
  else parts.push('--samples', samples, '--bounces', bounces);
  // The command measures files, the page doesn't.
  if (!heat && !address.startsWith('demo:')) parts.push('--exposure', '0');
  if (engine !== 'cpu' && !heat) parts.push('--engine', engine);
  if (duration > 0) parts.push('--time', Number(seconds.toFixed(3)));
  if (view.camera) parts.push(`--camera=${cameraText(view.camera)}`);
  // The command's lights take the place of all of a scene's.
  return parts.join(' ') + (view.light ? '  # with the lights where they were' : '');
}
