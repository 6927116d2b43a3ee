// Where the camera and the lights are, and how gestures move them. Points are [x, y, z], the Y axis upwards.

const add = (a, b) => a.map((value, axis) => value + b[axis]);
const subtract = (a, b) => a.map((value, axis) => value - b[axis]);
const scale = (a, factor) => a.map((value) => value * factor);
const length = (a) => Math.hypot(...a);
const normalized = (a) => scale(a, 1 / (length(a) || 1));
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];

/** A point turned around another: by one angle around the Y axis, and by one towards that, but never as far as it. */
function turned(point, around, across, upwards) {
  const [x, y, z] = subtract(point, around);
  const radius = Math.hypot(x, y, z);
  const longitude = Math.atan2(x, z) + across;
  const steep = Math.PI / 2 - 0.01;
  const latitude = Math.max(-steep, Math.min(steep, Math.asin(y / (radius || 1)) + upwards));
  const flat = radius * Math.cos(latitude);
  return add(around, [flat * Math.sin(longitude), radius * Math.sin(latitude), flat * Math.cos(longitude)]);
}

/** As the engine has numbers, so that links say all of them. */
const rounded = (point) => point.map(Math.fround);

export class View {
  #camera = null;
  #lights = [];
  #shown = null;
  /** The number of the light that gestures move, from 0. */
  chosen = 0;

  /** `{position, target, fovDegrees}`; null for the scene's own. */
  get camera() {
    return this.#camera;
  }

  set camera(camera) {
    const { position, target, fovDegrees } = camera ?? {};
    this.#camera = camera && { position: rounded(position), target: rounded(target), fovDegrees: Math.fround(fovDegrees) };
  }

  /** Where lights were moved to, by their numbers; null, and lights beyond the list, have their own positions. */
  get lights() {
    return this.#lights;
  }

  set lights(lights) {
    this.#lights = Array.from(lights, (light) => (light ? rounded(light) : null));
  }

  /** What the last picture told of itself. */
  show(shown) {
    this.#shown = shown;
  }

  get #size() {
    const [low, high] = this.#shown?.bounds ?? [[-1, -1, -1], [1, 1, 1]];
    return length(subtract(high, low)) || 1;
  }

  get #middle() {
    const [low, high] = this.#shown.bounds;
    return scale(add(low, high), 0.5);
  }

  get #current() {
    return this.camera ?? this.#shown?.camera;
  }

  /** Goes round what the camera looks at, by parts of a picture's height. */
  orbit(across, down) {
    const camera = this.#current;
    if (camera) {
      this.camera = { ...camera, position: turned(camera.position, camera.target, -3 * across, 3 * down) };
    }
  }

  /** Moves across the picture, by parts of its height. */
  pan(across, down) {
    const camera = this.#current;
    if (!camera) return;
    const away = subtract(camera.target, camera.position);
    const height = 2 * length(away) * Math.tan((camera.fovDegrees * Math.PI) / 360);
    const right = normalized(cross(normalized(away), [0, 1, 0]));
    const up = cross(right, normalized(away));
    this.#move(add(scale(right, -across * height), scale(up, down * height)));
  }

  /** Comes closer: below 1, the distance that is left. */
  dolly(factor) {
    const camera = this.#current;
    if (camera) {
      const away = subtract(camera.position, camera.target);
      const distance = Math.max(length(away) * factor, 1e-4 * this.#size);
      this.camera = { ...camera, position: add(camera.target, scale(normalized(away), distance)) };
    }
  }

  /** Flies: so many lengths of the scene to the right, upwards and forwards. */
  fly(right, up, forward) {
    const camera = this.#current;
    if (!camera) return;
    const ahead = normalized(subtract(camera.target, camera.position));
    const side = normalized(cross(ahead, [0, 1, 0]));
    const by = add(add(scale(side, right), [0, up, 0]), scale(ahead, forward));
    this.#move(scale(by, this.#size));
  }

  #move(by) {
    const camera = this.#current;
    this.camera = { ...camera, position: add(camera.position, by), target: add(camera.target, by) };
  }

  /** Moves the chosen light around the middle of the scene, by parts of a picture's height, and `factor` times as far away. */
  moveLight(across, up, factor = 1) {
    const light = this.#lights[this.chosen] ?? this.#shown?.lights[this.chosen]?.position;
    if (light) {
      const around = this.#middle;
      const away = subtract(turned(light, around, 3 * across, 3 * up), around);
      const lights = [...this.#lights];
      lights[this.chosen] = add(around, scale(away, factor));
      this.lights = lights;
    }
  }
}

/** Shows pointers, wheels and keys to a view, until `signal` ends it. `changed` is called after each move; `movesLight(event)`
 * says whether a gesture moves the light. */
export function control(canvas, view, movesLight, changed, signal) {
  const pointers = new Map();
  const on = (name, listener, options = {}) => canvas.addEventListener(name, listener, { signal, ...options });
  on('contextmenu', (event) => event.preventDefault());
  on('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    pointers.set(event.pointerId, event);
  });
  for (const end of ['pointerup', 'pointercancel']) {
    on(end, (event) => pointers.delete(event.pointerId));
  }
  on('pointermove', (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const height = canvas.clientHeight;
    const across = (event.clientX - last.clientX) / height;
    const down = (event.clientY - last.clientY) / height;
    const others = [...pointers.values()].filter((other) => other.pointerId !== event.pointerId);
    if (others.length > 0) {
      const [other] = others;
      const distance = (point) => Math.hypot(point.clientX - other.clientX, point.clientY - other.clientY) || 1;
      view.pan(across / 2, down / 2);
      view.dolly(distance(last) / distance(event));
    } else if (movesLight(event)) {
      view.moveLight(across, -down);
    } else if (event.buttons & 6) {
      view.pan(across, down);
    } else {
      view.orbit(across, down);
    }
    pointers.set(event.pointerId, event);
    changed();
  });
  on(
    'wheel',
    (event) => {
      event.preventDefault();
      const factor = Math.exp((event.deltaMode === 1 ? 30 : 1) * event.deltaY * 0.001);
      if (movesLight(event)) {
        view.moveLight(0, 0, factor);
      } else {
        view.dolly(factor);
      }
      changed();
    },
    { passive: false },
  );

  const held = new Set();
  const keys = { KeyD: [1, 0, 0], KeyA: [-1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0], KeyW: [0, 0, 1], KeyS: [0, 0, -1] };
  const arrows = { ArrowLeft: [-0.05, 0], ArrowRight: [0.05, 0], ArrowUp: [0, -0.05], ArrowDown: [0, 0.05] };
  let last = 0;
  const step = (now) => {
    if (held.size === 0 || signal?.aborted) return;
    const seconds = Math.min((now - last) / 1000, 0.1);
    last = now;
    for (const key of held) {
      view.fly(...keys[key].map((part) => 0.3 * seconds * part));
    }
    changed();
    requestAnimationFrame(step);
  };
  on('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.code in keys) {
      if (held.size === 0) {
        last = performance.now();
        requestAnimationFrame(step);
      }
      held.add(event.code);
    } else if (event.code in arrows) {
      const [across, down] = arrows[event.code];
      if (movesLight(event)) {
        view.moveLight(across, -down);
      } else {
        view.orbit(across, down);
      }
      changed();
    } else if (event.key === '+' || event.key === '-') {
      view.dolly(event.key === '+' ? 0.9 : 1 / 0.9);
      changed();
    } else {
      return;
    }
    event.preventDefault();
  });
  addEventListener('keyup', (event) => held.delete(event.code), { signal });
  addEventListener('blur', () => held.clear(), { signal });
}
