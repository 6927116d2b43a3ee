// A scene in a canvas: one order to the engine at a time, coarse pictures in motion, and finer ones once nothing moves.

import { Engine } from './engine.js';
import { Pace } from './pace.js';
import { View } from './view.js';

/** A picture in motion should take no longer, in milliseconds. */
const IN_MOTION = 50;
/** How long nothing must move before a picture gets finer, in milliseconds. */
const PAUSE = 250;
/** Pictures of what stands still: camera rays for each pixel, and how many mirrors light may come by. */
const STEPS = [{ samples: 1, bounces: 0 }, { samples: 4, bounces: 2 }, { samples: 16, bounces: 2 }];
/** Microseconds a pixel that these may take, until they were measured. */
const COSTS = [0.4, 2, 8];
/** A picture in motion has at least so many pixels for one of the page's, along each side. */
const COARSEST = 0.25;

export class Viewport {
  view = new View();
  engine = new Engine();
  state = {
    address: '',
    /** The files of a scene that came from this machine, which the engine needs again after a restart. */
    files: null,
    duration: 0,
    seconds: 0,
    heat: '',
    /** The engine that traces: `cpu` or `gpu`. */
    engine: 'cpu',
    /** In photographic stops; null for the scene's own. */
    exposure: null,
    background: 'sky',
    isPlaying: false,
    view: this.view,
  };
  /** The last order, and its answer. */
  work = {
    isOpen: false,
    isRendering: false,
    isWanted: false,
    /** Whether the picture is as fine as it gets. */
    isSettled: false,
    /** Index of the picture in STEPS; -1 in motion. */
    step: -1,
    /** When something moved last. */
    moved: 0,
    /** Microseconds a pixel, of each of the steps. */
    costs: [...COSTS],
    /** The times of pictures in motion. */
    pace: new Pace(COSTS[0] * 1e-3),
    /** A finer picture that would take longer, in milliseconds, isn't made: the next gesture would wait for it. */
    patience: 4000,
    timer: 0,
    /** How the last picture was asked for, and its description of itself. */
    look: null,
    shown: null,
    /** Whether a GPU is open, and the engine that was chosen last. */
    hasGpu: false,
    chosen: 'cpu',
    /** In how many pixels of the view the GPU and the processor differ; null where that isn't known. */
    differing: null,
  };
  #canvas;
  #on;
  #observer;

  /** `on` has functions: `drawn({look, shown, milliseconds})`, `settled()`, `compared(pixels)`, `moved()` while an animation
   * plays, `engine(name)`, and `failed(error)`; each may be missing. */
  constructor(canvas, on) {
    this.#canvas = canvas;
    this.#on = on;
    this.#observer = new ResizeObserver(() => this.changed());
    this.#observer.observe(canvas);
  }

  /** Ends the engine and everything that would go on by itself. */
  close() {
    this.state.isPlaying = this.work.isOpen = false;
    clearTimeout(this.work.timer);
    this.#observer.disconnect();
    this.engine.close();
  }

  /** Something moved: a coarse picture is due at once, finer ones once nothing moves any more. */
  changed() {
    const { work } = this;
    work.step = -1;
    work.differing = null;
    work.isSettled = false;
    work.moved = performance.now();
    work.isWanted = true;
    this.#render();
  }

  /** The size of a picture with so many pixels for one of the page's, along each side. */
  #size(factor) {
    const side = (length) => Math.max(Math.round(length * factor), 1);
    return { width: side(this.#canvas.clientWidth), height: side(this.#canvas.clientHeight) };
  }

  /** More than two pixels for one of the page's aren't seen. */
  get #whole() {
    return Math.min(devicePixelRatio, 2);
  }

  /** Size and samples of the picture that is due. */
  #plan() {
    const { work } = this;
    if (work.step >= 0) {
      return { ...this.#size(this.#whole), ...STEPS[work.step] };
    }
    const { width, height } = this.#size(1);
    const factor = Math.sqrt(work.pace.pixels(IN_MOTION) / (width * height));
    return { ...this.#size(Math.min(Math.max(factor, COARSEST), this.#whole)), ...STEPS[0] };
  }

  /** What the engine is asked for, beside sizes and samples. */
  #look() {
    const { seconds, engine, exposure, background, heat } = this.state;
    const { camera, lights } = this.view;
    return { seconds, camera, lights, engine, background, exposureStops: exposure, heat: heat || null };
  }

  async #render() {
    const { work } = this;
    if (!work.isOpen || work.isRendering || !work.isWanted) return;
    work.isRendering = true;
    work.isWanted = false;
    const { step } = work;
    const look = { ...this.#look(), ...this.#plan() };
    try {
      const answer = await this.engine.ask('render', { look });
      const pixels = look.width * look.height;
      if (step < 0) work.pace.add(pixels, answer.milliseconds);
      else work.costs[step] = (answer.milliseconds * 1000) / pixels;
      this.#draw(look, answer);
      if (look.engine === 'gpu' && step === 0 && !work.isWanted) await this.#compare(look);
    } catch (error) {
      if (error.isClosed) return;
      this.#on.failed?.(error);
      if (error.isBroken) this.#restart();
      if (look.engine === 'gpu') {
        work.hasGpu = false;
        this.#trace('cpu');
      }
    }
    work.isRendering = false;
    if (work.isWanted) {
      this.#render();
    } else {
      this.#refineLater();
    }
  }

  #restart() {
    this.work.isOpen = this.work.hasGpu = false;
    this.engine.restart();
  }

  #draw(look, { shown, milliseconds, pixels }) {
    const canvas = this.#canvas;
    if (canvas.width !== look.width || canvas.height !== look.height) {
      canvas.width = look.width;
      canvas.height = look.height;
    }
    const bytes = new Uint8ClampedArray(pixels.buffer, pixels.byteOffset, pixels.byteLength);
    canvas.getContext('2d').putImageData(new ImageData(bytes, look.width, look.height), 0, 0);
    this.view.show(shown);
    Object.assign(this.work, { look, shown });
    this.#on.drawn?.({ look, shown, milliseconds });
  }

  /** Has the processor trace the GPU's picture as well. */
  async #compare(look) {
    const { differing } = await this.engine.ask('differing', { look });
    // Another view is due meanwhile, or the processor's picture.
    if (this.work.isWanted) return;
    this.work.differing = differing;
    this.#on.compared?.(differing);
  }

  /** Other pictures follow, which take other times. */
  #forgetCosts() {
    this.work.costs = [...COSTS];
    this.work.pace = new Pace(COSTS[0] * 1e-3);
  }

  #trace(name) {
    this.state.engine = this.work.chosen = name;
    this.#forgetCosts();
    this.#on.engine?.(name);
    this.changed();
  }

  /** Has pictures traced by another engine, where there is one. */
  async chooseEngine(name) {
    const { work } = this;
    work.chosen = name;
    if (name === 'cpu') return this.#trace('cpu');
    try {
      if (!work.hasGpu) {
        await this.engine.ask('openGpu');
        work.hasGpu = true;
      }
      // Somebody may have chosen again.
      if (work.chosen === name) this.#trace(name);
    } catch (error) {
      this.#on.failed?.(new Error(`${error.message}. The processor goes on.`));
      this.#trace('cpu');
    }
  }

  /** The next finer picture, once nothing has moved for a while. */
  #refineLater() {
    const { work, state } = this;
    clearTimeout(work.timer);
    const next = work.step + 1;
    if (state.isPlaying || next >= (state.heat ? 1 : STEPS.length)) return this.#settle();
    const { width, height } = this.#size(this.#whole);
    const expected = next > 0 ? work.costs[next] * width * height * 1e-3 : work.pace.of(width * height);
    if (expected > work.patience) return this.#settle();
    const wait = Math.max(work.moved + PAUSE - performance.now(), 0);
    work.timer = setTimeout(() => {
      if (work.isRendering || work.isWanted) return;
      work.step = next;
      work.isWanted = true;
      this.#render();
    }, wait);
  }

  #settle() {
    this.work.isSettled = true;
    this.#on.settled?.();
  }

  /** Opens a scene by an order to the engine, seen as `from` says: `seconds`, `camera`, `lights`, `exposure`, `background`. Without
   * a scene nothing is rendered until `play` is called. Returns the engine's answer; where that is an error, the last scene stays. */
  async open(order, { address, files = null, from = {} }) {
    const { work, state, view } = this;
    work.isOpen = false;
    state.isPlaying = false;
    try {
      const { opened } = await this.engine.ask(order.kind, order);
      Object.assign(state, { address, files, duration: opened.durationSeconds, seconds: from.seconds ?? opened.stillSeconds });
      state.exposure = from.exposure ?? null;
      state.background = from.background ?? 'sky';
      this.#forgetCosts();
      view.camera = from.camera ?? null;
      view.lights = from.lights ?? [];
      view.chosen = 0;
      work.isOpen = true;
      return opened;
    } catch (error) {
      if (error.isBroken) this.#restart();
      else work.isOpen = state.address !== '';
      throw error;
    }
  }

  /** What a small picture, of the proportions of the canvas, shows of the scene. */
  async probe() {
    const height = 64;
    const { width, height: whole } = this.#size(1);
    const look = { ...this.#look(), engine: 'cpu', heat: null, width: Math.max(Math.round((width * height) / whole), 1), height };
    return (await this.engine.ask('render', { look })).shown;
  }

  /** Has an animation play, or stand still. */
  play(isPlaying) {
    const { work, state } = this;
    state.isPlaying = isPlaying && state.duration > 0;
    // As links say it.
    if (!state.isPlaying) state.seconds = Number(state.seconds.toFixed(3));
    this.#on.moved?.();
    this.changed();
    let last = performance.now();
    const step = (now) => {
      if (!state.isPlaying) return;
      // Pictures that take long don't make it slower.
      if (!work.isRendering) {
        state.seconds = (state.seconds + (now - last) / 1000) % state.duration;
        last = now;
        this.#on.moved?.();
        this.changed();
      }
      requestAnimationFrame(step);
    };
    if (state.isPlaying) requestAnimationFrame(step);
  }
}
