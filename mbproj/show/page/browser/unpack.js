// The numbers of the page: base 64, compressed, as mbproj/show/page/series.py writes them.

const NO_NUMBER = -(2 ** 31);

/** All bytes of the element with this id. */
async function bytesOf(id) {
  const text = atob(document.getElementById(id).textContent.trim());
  const packed = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** A block of whole multiples of steps; `at(row, column)` is a number, NaN where there is none. */
class Block {
  constructor(bytes, { at, rows, columns, order, steps }) {
    Object.assign(this, { rows, columns, steps });
    const count = rows * columns;
    this.whole = new Int32Array(count); // column after column
    for (let i = 0; i < count; i++) {
      const [a, b, c, d] = [0, 1, 2, 3].map((plane) => bytes[at + plane * count + i]);
      const unsigned = (a | (b << 8) | (c << 16) | (d << 24)) >>> 0;
      this.whole[i] = (unsigned >>> 1) ^ -(unsigned & 1);
    }
    const orders = Math.min(order, Math.max(rows - 1, 0));
    for (let column = 0; column < columns; column++) this.#sum(column * rows, orders);
  }

  /** Turns differences of this order into the numbers; sums wrap around as the differences did. */
  #sum(start, orders) {
    for (let turn = orders - 1; turn >= 0; turn--) {
      for (let row = turn + 1; row < this.rows; row++) {
        this.whole[start + row] = (this.whole[start + row] + this.whole[start + row - 1]) | 0;
      }
    }
  }

  at(row, column) {
    const whole = this.whole[column * this.rows + row];
    return whole === NO_NUMBER ? NaN : whole * this.steps[this.steps.length > 1 ? column : 0];
  }

  /** All numbers, row after row. */
  rowsOf() {
    return Float64Array.from({ length: this.rows * this.columns }, (_, i) => this.at(Math.floor(i / this.columns), i % this.columns));
  }
}
