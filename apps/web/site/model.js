// Files of a model on a server: the model itself, and those that it names.

/** A number of bytes, in words. */
export const megabytes = (bytes) => `${(bytes / 1e6).toFixed(1)} MB`;

const text = (bytes) => new TextDecoder().decode(bytes);

/** The JSON of a glTF file, of either form. */
function gltf(bytes) {
  if (text(bytes.subarray(0, 4)) !== 'glTF') return JSON.parse(text(bytes));
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  return JSON.parse(text(bytes.subarray(20, 20 + view.getUint32(12, true))));
}

/** The files that a file names, as relative addresses. A broken file names none: a reader says what is wrong with it. */
export function namedFiles(name, bytes) {
  const end = name.toLowerCase().match(/\.(\w+)$/)?.[1];
  const named = () => {
    if (end === 'gltf' || end === 'glb') {
      const { buffers = [], images = [] } = gltf(bytes);
      return [...buffers, ...images].map(({ uri }) => uri).filter((uri) => typeof uri === 'string');
    }
    // Names of OBJ files are no addresses.
    const names = (pattern) => [...text(bytes).matchAll(pattern)].map(([, name]) => name.trim().split('\\').map(encodeURIComponent).join('/').replaceAll('%2F', '/'));
    if (end === 'obj') return names(/^[ \t]*mtllib[ \t]+(.+)$/gm);
    if (end === 'mtl') return names(/^[ \t]*(?:map_\w+|bump|disp|norm)[ \t]+(?:-\w+(?:[ \t]+(?:[-+.\d]+|on|off))+[ \t]+)*(.+)$/gim);
    return [];
  };
  try {
    // Data in the file itself, and files of other servers, aren't fetched.
    return [...new Set(named())].filter((uri) => !/^(?:[a-z][a-z\d+.-]*:|\/)/i.test(uri));
  } catch {
    return [];
  }
}

/** Fetches a file; `onBytes` is told how many more bytes have come, and at first how many will, where the server says so. */
async function fetchBytes(url, { signal, onBytes }) {
  const response = await fetch(url, { signal });
  if (!response.ok) throw new Error(`${url.pathname}: the server answers ${response.status}`);
  // The length of a compressed answer isn't the file's.
  const total = response.headers.has('Content-Encoding') ? 0 : Number(response.headers.get('Content-Length') ?? 0);
  onBytes?.(0, total);
  const parts = [];
  for (const reader = response.body.getReader(); ; ) {
    const { done, value } = await reader.read();
    if (done) return new Uint8Array(await new Blob(parts).arrayBuffer());
    parts.push(value);
    onBytes?.(value.byteLength, 0);
  }
}

/** Fetches a model with its files, as the engine's order `openFiles`. `onProgress(loaded, total)` has bytes; `total` is zero where a
 * server doesn't say it. Files that the model names and that aren't there are left out: the reader says what it needs. */
export async function fetchModel(url, { signal, onProgress = () => {} } = {}) {
  let [loaded, total] = [0, 0];
  const onBytes = (more, expected) => {
    loaded += more;
    total += expected;
    onProgress(loaded, total);
  };
  const name = decodeURIComponent(url.pathname.split('/').at(-1));
  const found = new Map([[name, await fetchBytes(url, { signal, onBytes })]]);
  let wanted = namedFiles(name, found.get(name));
  while (wanted.length > 0) {
    const fetched = await Promise.all(
      wanted.map(async (uri) => {
        try {
          return [decodeURIComponent(uri), await fetchBytes(new URL(uri, url), { signal, onBytes })];
        } catch (error) {
          if (signal?.aborted) throw error;
          return [decodeURIComponent(uri), null];
        }
      }),
    );
    for (const [path, bytes] of fetched) found.set(path, bytes);
    const next = fetched.flatMap(([path, bytes]) => (bytes ? namedFiles(path, bytes) : []));
    wanted = next.filter((uri) => !found.has(decodeURIComponent(uri)));
  }
  const there = [...found].filter(([, bytes]) => bytes);
  return { kind: 'openFiles', name, paths: there.map(([path]) => path), files: there.map(([, bytes]) => new Blob([bytes])) };
}
