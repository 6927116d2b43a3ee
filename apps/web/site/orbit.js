// Cameras around a scene, in the words of `camera-orbit`.

const RADIANS = { rad: 1, deg: Math.PI / 180 };
const METRES = { m: 1, cm: 0.01, mm: 0.001 };
/** How near the axis a camera may come, in radians. */
const STEEPEST = 0.01;

/** A number with one of some units, in the first of these; null where it is `auto`. */
function quantity(text, units) {
  if (text === 'auto') return null;
  const [, digits, unit] = text.match(/^([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)([a-z%]+)$/i) ?? [];
  const value = Number(digits) * units[unit];
  if (!Number.isFinite(value)) throw new Error(`camera-orbit: \`${text}\` is none of auto and a number with ${Object.keys(units).join(', ')}`);
  return value;
}

/** What `theta phi radius` says: the angle around the Y axis from +Z, the angle from the Y axis, both in radians, and the distance
 * from the middle of the scene; null stands for `auto`, and `share` for a part of the distance that that would be. */
export function parseOrbit(text) {
  const words = (text ?? '').trim().split(/\s+/).filter(Boolean);
  if (words.length > 3) throw new Error(`camera-orbit: \`${text}\` has more than theta, phi and radius`);
  const [theta = 'auto', phi = 'auto', radius = 'auto'] = words;
  const [, percent] = radius.match(/^(\d+\.?\d*|\.\d+)%$/) ?? [];
  const orbit = { theta: quantity(theta, RADIANS), phi: quantity(phi, RADIANS), radius: null, share: Number(percent ?? 100) / 100 };
  if (percent === undefined) orbit.radius = quantity(radius, METRES);
  if (orbit.radius <= 0 && orbit.radius !== null || orbit.share <= 0) throw new Error(`camera-orbit: \`${radius}\` isn't above zero`);
  return orbit;
}

/** The middle of what a picture shows. */
export const middle = ({ bounds: [low, high] }) => low.map((value, axis) => (value + high[axis]) / 2);

/** The camera of an orbit around a point, where `auto` is the camera of a picture. */
export function orbitCamera({ theta, phi, radius, share }, { camera }, target) {
  const [x, y, z] = camera.position.map((value, axis) => value - target[axis]);
  const away = Math.hypot(x, y, z) || 1;
  const distance = radius ?? share * away;
  const around = theta ?? Math.atan2(x, z);
  const down = Math.max(STEEPEST, Math.min(Math.PI - STEEPEST, phi ?? Math.acos(y / away)));
  const from = [Math.sin(down) * Math.sin(around), Math.cos(down), Math.sin(down) * Math.cos(around)];
  return { position: target.map((value, axis) => value + distance * from[axis]), target, fovDegrees: camera.fovDegrees };
}
