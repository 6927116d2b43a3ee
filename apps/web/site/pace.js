/** Weight of a picture's time, in relation to the next one's. */
const KEPT = 0.8;
/** Least spread of sizes, as a part of their mean, from which the time of a pixel can be found. */
const SPREAD = 0.05;
/** Time of a picture's pixels, as a part of the time that any picture takes, which is always allowed. */
const BESIDES = 0.3;
/** Least time of a picture, in milliseconds: some browsers' clocks go in steps. */
const LEAST = 0.1;

/** The time of a picture by its size, from the last ones: so many milliseconds for any picture, and so many for each pixel. */
export class Pace {
  /** @param {number} ofPixel milliseconds a pixel, until pictures were measured. */
  constructor(ofPixel) {
    this.always = 0;
    this.ofPixel = ofPixel;
    // Sums over pictures: of one, pixels, milliseconds, squares of pixels, and pixels times milliseconds.
    this.sums = [0, 0, 0, 0, 0];
  }

  /** Counts a picture, by the method of least squares. */
  add(pixels, measured) {
    const milliseconds = Math.max(measured, LEAST);
    const terms = [1, pixels, milliseconds, pixels * pixels, pixels * milliseconds];
    this.sums = this.sums.map((sum, index) => sum * KEPT + terms[index]);
    const [count, ...others] = this.sums;
    const [meanPixels, mean, squares, products] = others.map((sum) => sum / count);
    const variance = squares - meanPixels * meanPixels;
    if (variance > (SPREAD * meanPixels) ** 2) {
      const slope = (products - meanPixels * mean) / variance;
      this.ofPixel = Math.min(Math.max(slope, (0.02 * mean) / meanPixels), mean / meanPixels);
      this.always = Math.max(mean - this.ofPixel * meanPixels, 0);
    } else {
      // Both parts as much more or less as the whole.
      const change = mean / this.of(meanPixels);
      this.always *= change;
      this.ofPixel *= change;
    }
  }

  /** Milliseconds that a picture of so many pixels takes. */
  of(pixels) {
    return this.always + this.ofPixel * pixels;
  }

  /** How many pixels a picture has that takes so many milliseconds; more, where fewer would hardly be faster. */
  pixels(milliseconds) {
    return Math.max(milliseconds - this.always, BESIDES * this.always) / this.ofPixel;
  }
}
