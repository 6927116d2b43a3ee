// `<umbrage-viewer src="model.glb">`, for anyone's page: `<script type="module" src="umbrage-viewer.js"></script>` defines it.

import { fetchModel } from './model.js';
import { middle, orbitCamera, parseOrbit } from './orbit.js';
import { control } from './view.js';
import { Viewport } from './viewport.js';

/** Radians a second of `auto-rotate`, and how long a gesture stops it, in milliseconds: as of <model-viewer>. */
const TURN = Math.PI / 32;
const REST = 3000;

const MARKUP = `<style>
  :host { display: block; position: relative; width: 300px; height: 150px; overflow: hidden; contain: strict; }
  :host([hidden]) { display: none; }
  canvas, img { position: absolute; width: 100%; height: 100%; }
  canvas { object-fit: cover; outline-offset: -2px; }
  canvas.moves { cursor: grab; touch-action: pan-y; }
  img { object-fit: contain; pointer-events: none; }
  progress { position: absolute; left: 15%; bottom: 12px; width: 70%; pointer-events: none; }
  p { position: absolute; inset: auto 0 0; margin: 0; padding: 8px; background: #3a1c1c; color: #fff; font: 14px system-ui, sans-serif; }
  [hidden] { display: none; }
</style>
<canvas part="picture" role="img"></canvas>
<img part="poster" alt="" hidden>
<progress part="progress" aria-label="Loading" value="0" hidden></progress>
<p part="error" role="alert" hidden></p>`;

export class UmbrageViewer extends HTMLElement {
  static observedAttributes = ['src', 'camera-orbit', 'camera-controls', 'auto-rotate', 'autoplay', 'exposure', 'poster', 'alt'];

  #viewport = null;
  /** Ends what follows from `src`, and gestures. */
  #loading = null;
  #controls = null;
  /** What a small picture showed of the scene as the file has it; null until it is there. */
  #probed = null;
  #isShown = false;
  #isVisible = false;
  #observer = null;
  #share = { engine: 0, model: 0 };
  /** When a gesture moved the camera last. */
  #moved = -Infinity;
  #isTurning = false;

  constructor() {
    super();
    this.attachShadow({ mode: 'open' }).innerHTML = MARKUP;
  }

  /** Whether the first picture is there. */
  get loaded() {
    return this.#isShown;
  }

  connectedCallback() {
    this.#viewport = new Viewport(this.#part('canvas'), { drawn: () => this.#drawn(), failed: (error) => this.#fail(error) });
    this.#viewport.engine.onprogress = ({ loaded, total }) => this.#progress('engine', loaded / total);
    this.#share.engine = 0;
    this.#observer = new IntersectionObserver(([{ isIntersecting }]) => {
      this.#isVisible = isIntersecting;
      this.#turn();
      this.#play();
    });
    this.#observer.observe(this);
    for (const name of ['poster', 'alt', 'camera-controls', 'src']) this.attributeChangedCallback(name);
  }

  disconnectedCallback() {
    this.#loading?.abort();
    this.#controls?.abort();
    this.#observer.disconnect();
    this.#viewport.close();
    this.#viewport = this.#probed = null;
  }

  attributeChangedCallback(name) {
    if (!this.#viewport) return;
    switch (name) {
      case 'src':
        this.#load();
        break;
      case 'poster':
        if (this.hasAttribute('poster')) this.#part('img').src = this.getAttribute('poster');
        this.#part('img').hidden = this.#isShown || !this.hasAttribute('poster');
        break;
      case 'alt':
        this.#part('canvas').setAttribute('aria-label', this.getAttribute('alt') ?? '');
        break;
      case 'camera-controls':
        this.#control();
        break;
      case 'autoplay':
        this.#play();
        break;
      default:
        this.#look();
    }
  }

  #part(name) {
    return this.shadowRoot.querySelector(name);
  }

  #tell(name, detail) {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }

  /** Tells how much of the engine and the model have come, from 0 to 1: never less than before, as files name others. */
  #progress(part, share) {
    this.#share[part] = Math.max(this.#share[part], Math.min(share, 1));
    const totalProgress = (this.#share.engine + this.#share.model) / 2;
    this.#part('progress').value = totalProgress;
    this.#tell('progress', { totalProgress });
  }

  #fail(error) {
    this.#part('p').textContent = error.message;
    this.#part('p').hidden = false;
    this.#part('progress').hidden = true;
    this.#tell('error', { type: 'loadfailure', sourceError: error });
  }

  /** Opens the scene of `src`; the picture, the poster or nothing is shown until its first picture is there. */
  async #load() {
    this.#loading?.abort();
    const { signal } = (this.#loading = new AbortController());
    const src = this.getAttribute('src');
    this.#isShown = false;
    this.#probed = null;
    this.#part('p').hidden = true;
    this.#part('progress').hidden = !src;
    this.attributeChangedCallback('poster');
    if (!src) return;
    try {
      this.#share.model = 0;
      const order = await this.#order(src, signal);
      this.#progress('model', 1);
      if (signal.aborted) return;
      const viewport = this.#viewport;
      await viewport.open(order, { address: src });
      const probed = await viewport.probe();
      if (signal.aborted) return;
      this.#probed = probed;
      this.#progress('engine', 1);
      this.#look();
      this.#play();
    } catch (error) {
      if (!signal.aborted) this.#fail(error);
    }
  }

  #order(src, signal) {
    if (src.startsWith('demo:')) return { kind: 'openDemo', address: src };
    const onProgress = (loaded, total) => total > 0 && this.#progress('model', loaded / total);
    return fetchModel(new URL(src, document.baseURI), { signal, onProgress });
  }

  /** Sees the scene as the attributes say. */
  #look() {
    if (!this.#probed) return;
    const { state, view } = this.#viewport;
    try {
      const isAround = this.hasAttribute('camera-orbit') || this.hasAttribute('auto-rotate');
      // The gallery's scenes have walls and floors, and cameras that look at their subject.
      const target = state.address.startsWith('demo:') ? this.#probed.camera.target : middle(this.#probed);
      view.camera = isAround ? orbitCamera(parseOrbit(this.getAttribute('camera-orbit')), this.#probed, target) : null;
      const exposure = Number(this.getAttribute('exposure') ?? 1);
      if (!(exposure > 0 && exposure < Infinity)) throw new Error('exposure: a number above zero is needed');
      state.exposure = this.#probed.exposureStops + Math.log2(exposure);
    } catch (error) {
      return this.#fail(error);
    }
    this.#viewport.changed();
    this.#turn();
  }

  #play() {
    if (this.#probed) this.#viewport.play(this.hasAttribute('autoplay') && this.#isVisible);
  }

  #drawn() {
    // Another scene's last picture may come while the next one is opened.
    if (this.#isShown || !this.#probed) return;
    this.#isShown = true;
    this.#part('img').hidden = this.#part('progress').hidden = true;
    this.#tell('load', { url: this.getAttribute('src') });
  }

  #control() {
    this.#controls?.abort();
    const canvas = this.#part('canvas');
    const moves = this.hasAttribute('camera-controls');
    canvas.classList.toggle('moves', moves);
    if (moves) canvas.tabIndex = 0;
    else canvas.removeAttribute('tabindex');
    if (!moves) return;
    this.#controls = new AbortController();
    const { view } = this.#viewport;
    const changed = () => {
      this.#moved = performance.now();
      this.#viewport.changed();
    };
    control(canvas, view, () => false, changed, this.#controls.signal);
  }

  /** Goes round the scene, where `auto-rotate` says so, while it is seen and nobody moves it. */
  #turn() {
    const viewport = this.#viewport;
    const goesOn = () => this.#viewport === viewport && this.#probed && this.#isVisible && this.hasAttribute('auto-rotate');
    if (this.#isTurning || !goesOn() || matchMedia('(prefers-reduced-motion: reduce)').matches) return;
    this.#isTurning = true;
    let last = performance.now();
    const step = (now) => {
      this.#isTurning = goesOn();
      if (!this.#isTurning) return;
      // Pictures that take long don't make it slower.
      if (!viewport.work.isRendering) {
        if (now > this.#moved + REST) {
          viewport.view.orbit((-TURN * (now - last)) / 3000, 0);
          viewport.changed();
        }
        last = now;
      }
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}

if (!customElements.get('umbrage-viewer')) customElements.define('umbrage-viewer', UmbrageViewer);
