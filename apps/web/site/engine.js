// Orders to the worker, as promises.

export class Engine {
  #worker;
  #number = 0;
  #waiting = new Map();

  constructor() {
    this.#start();
  }

  #start() {
    this.#worker = new Worker(new URL('worker.js', import.meta.url), { type: 'module' });
    this.#worker.onmessage = ({ data }) => this.#answer(data);
    this.#worker.onerror = (event) => this.#fail(event.message || 'the engine could not be loaded');
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

  #fail(why) {
    for (const { reject } of this.#waiting.values()) {
      reject(new Error(why));
    }
    this.#waiting.clear();
  }

  /** Starts anew, without a scene. */
  restart() {
    this.#worker.terminate();
    this.#fail('the engine was started anew');
    this.#start();
  }

  ask(kind, order = {}) {
    const number = ++this.#number;
    return new Promise((resolve, reject) => {
      this.#waiting.set(number, { resolve, reject });
      this.#worker.postMessage({ number, kind, ...order });
    });
  }
}
