// The server of the page, and a browser: `WEB` is the program that serves it, `PAGE` the folder where it is, `CHROMIUM` the
// browser; `SHOTS` is a folder that keeps screenshots to look at.

import { spawn } from 'node:child_process';
import { createInterface } from 'node:readline';
import { chromium } from 'playwright-core';

export const { WEB = '../../target/debug/web', PAGE = '../../target/web', SHOTS, CHROMIUM = '/usr/bin/chromium' } = process.env;
/** Software rendering on a busy machine takes its time. */
export const WAIT = 40_000;

export async function launch() {
  const server = spawn(WEB, ['serve', '--built', PAGE, '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
  let address;
  for await (const line of createInterface({ input: server.stdout })) {
    address = line.match(/http:\S+/)?.[0];
    break;
  }
  const browser = await chromium.launch({
    executablePath: CHROMIUM,
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--enable-precise-memory-info'],
  });
  const close = async () => {
    await browser.close();
    server.kill();
  };
  return { browser, address, close };
}
