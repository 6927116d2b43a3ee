// The size of pictures in motion: `npm test`, or `node --test pace.test.mjs`, which needs no browser.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Pace } from '../../apps/web/site/pace.js';

const BUDGET = 50;
const WHOLE = 1280 * 688;

/** Pixels of the last of so many pictures that take `always` and `ofPixel` milliseconds, between a sixteenth and all of them. */
function play(pace, always, ofPixel, pictures = 60) {
  let pixels = 0;
  for (let picture = 0; picture < pictures; picture++) {
    pixels = Math.min(Math.max(pace.pixels(BUDGET), WHOLE / 16), WHOLE);
    // A machine is never quite steady.
    pace.add(pixels, (always + ofPixel * pixels) * (1 + 0.1 * Math.sin(7 * picture)));
  }
  return pixels;
}

test('cheap pictures are whole', () => {
  assert.equal(play(new Pace(4e-4), 1, 2e-5), WHOLE);
});

test('dear pixels make pictures smaller, so that they take what they may', () => {
  const pixels = play(new Pace(4e-4), 5, 2e-4);
  const milliseconds = 5 + 2e-4 * pixels;
  assert.ok(milliseconds > 0.7 * BUDGET && milliseconds < 1.3 * BUDGET, `${milliseconds} ms`);
});

test('pictures that take long at any size stay large', () => {
  const pixels = play(new Pace(4e-4), 55, 1e-5);
  assert.ok(pixels > WHOLE / 2, `${pixels} pixels`);
});

test('pictures recover once they are cheap again', () => {
  const pace = new Pace(4e-4);
  assert.ok(play(pace, 5, 5e-4) < WHOLE / 4);
  assert.equal(play(pace, 1, 2e-5), WHOLE);
});

test('a clock that stands still does no harm', () => {
  const pace = new Pace(4e-4);
  for (let picture = 0; picture < 5; picture++) pace.add(WHOLE, 0);
  assert.equal(play(pace, 1, 2e-5), WHOLE);
});
