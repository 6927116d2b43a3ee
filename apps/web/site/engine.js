// Orders to the worker, as promises.

/** A worker that runs a script of these, wherever they come from: browsers take workers from a page's own server alone. */
function worker(url) {
  if (url.origin === location.origin) return new Worker(url, { type: 'module' });
  const script = URL.createObjectURL(new Blob([`import ${JSON.stringify(url.href)};`], { type: 'text/javascript' }));
  return new Worker(script, { type: 'module' });
}

export class Engine {
  /** Called with `{loaded, total}` in bytes while the engine is loaded. */
  onprogress = null;
  #worker;
  #number = 0;
  #waiting = new Map();

  constructor() {
    this.#start();
  }

  #start() {
    this.#worker = worker(new URL('worker.js', import.meta.url));
    this.#worker.onmessage = ({ data }) => (data.progress ? this.onprogress?.(data.progress) : this.#answer(data));
    this.#worker.onerror = (event) => this.#fail(new Error(event.message || 'the engine could not be loaded'));
  }

  #answer({ number, error, isBroken, ...answer }) {
    const { resolve, reject } = this.#waiting.get(number);
    this.#waiting.delete(number);
    if (error === undefined) {
      resolve(answer);
    } else {
      reject(Object.assign(new Error(error), { isBroken }));
    }
  }

  #fail(error) {
    for (const { reject } of this.#waiting.values()) {
      reject(error);
    }
    this.#waiting.clear();
  }

  /** Starts anew, without a scene. */
  restart() {
    this.#worker.terminate();
    this.#fail(new Error('the engine was started anew'));
    this.#start();
  }

  /** Ends the worker. Orders that wait are rejected by errors with `isClosed`. */
  close() {
    this.#worker.terminate();
    this.#fail(Object.assign(new Error('the engine was closed'), { isClosed: true }));
  }

  ask(kind, order = {}) {
    const number = ++this.#number;
    return new Promise((resolve, reject) => {
      this.#waiting.set(number, { resolve, reject });
      this.#worker.postMessage({ number, kind, ...order });
    });
  }
}
