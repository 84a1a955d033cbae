// The compiled controller: a WebAssembly module with one controller in its memory, and views of what it reads and
// writes. Pure JavaScript without a document, so that tests run it anywhere.

export const CHUNK = 128; // most ticks of one call, as kChunk in controller.cpp

// Names, types and sizes in the order of address() in controller.cpp. n: joints; C: CHUNK.
const COMMANDS = 2 * CHUNK + 1;
const ARRAYS = [
  ["q", Float64Array, (n) => n],
  ["twists", Float64Array, () => 6 * COMMANDS],
  ["targets", Float64Array, () => 16 * COMMANDS],
  ["noise", Float64Array, (n) => CHUNK * n],
  ["asked", Float64Array, () => 6],
  ["off", Float64Array, () => 2 * CHUNK],
  ["fullRates", Float64Array, (n) => n],
  ["rateLower", Float64Array, (n) => n],
  ["rateUpper", Float64Array, (n) => n],
  ["nullVector", Float64Array, (n) => n],
  ["faults", Float64Array, (n) => 3 * n],
  ["relative", Float64Array, (n) => n],
  ["costs", Int32Array, (n) => n],
  ["cost", Float64Array, (n) => 6 * n],
  ["direction", Float64Array, () => 36],
  ["sigma", Float64Array, () => 3],
  ["axis", Float64Array, () => 9],
  ["lost", Int32Array, () => 1],
  ["last", Float64Array, (n) => n],
  ["record.q", Float64Array, (n) => CHUNK * n],
  ["record.measured", Float64Array, (n) => CHUNK * n],
  ["record.rates", Float64Array, (n) => CHUNK * n],
  ["record.pose", Float64Array, () => CHUNK * 16],
  ["record.command", Float64Array, () => CHUNK * 6],
  ["record.residual", Float64Array, () => CHUNK * 6],
  ["record.task_error", Float64Array, () => CHUNK],
  ["record.damping", Float64Array, () => CHUNK],
  ["record.scale", Float64Array, () => CHUNK],
  ["record.lower", Float64Array, (n) => CHUNK * n],
  ["record.upper", Float64Array, (n) => CHUNK * n],
  ["record.status", Int32Array, () => CHUNK],
  ["record.health", Int8Array, (n) => CHUNK * n],
  ["record.known", Int8Array, (n) => CHUNK * n],
  ["record.active", Int8Array, (n) => CHUNK * n],
];

export class Core {
  constructor(module) {
    this.exports = new WebAssembly.Instance(module).exports;
    this.exports._initialize();
    this.roomFor = 0;
  }

  // Where memory grew, views of it are void.
  look() {
    this.exports.look();
  }

  give(setup) {
    if (setup.length !== this.roomFor) this.at = this.exports.room(setup.length);
    this.roomFor = setup.length;
    new Float64Array(this.exports.memory.buffer, this.at, setup.length).set(setup);
  }

  // A controller at rest, and a plant; every joint is whole.
  load(setup, plant) {
    this.give(setup);
    this.n = this.exports.load(plant.follow, plant.dead, plant.resolution);
    if (!this.n) throw new Error("not enough memory for this arm");
    this.map();
  }

  // Other settings; what happened, and what is broken, stays.
  change(setup) {
    this.give(setup);
    this.exports.change();
    this.map();
  }

  map() {
    const buffer = this.exports.memory.buffer;
    ARRAYS.forEach(([name, Type, size], which) => {
      this[name] = new Type(buffer, this.exports.address(which), size(this.n));
    });
  }

  get memory() {
    return this.exports.memory.buffer.byteLength;
  }
}

export const RECORD = ARRAYS.map(([name]) => name).filter((name) => name.startsWith("record.")).map((name) => name.slice(7));
