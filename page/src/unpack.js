// The inverse of pack.py: a document whose arrays are in one block of bytes.

const TYPES = { float64: Float64Array, float32: Float32Array, int32: Int32Array, int8: Int8Array };

export async function inflate(base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export function unpack(text, block) {
  return JSON.parse(text, (_, value) => {
    if (value?.array === undefined) return value;
    const [type, shape, offset] = value.array;
    const count = shape.reduce((a, b) => a * b, 1);
    return type === "int8" ? new Int8Array(block.slice(offset, offset + count).buffer) : columns(TYPES[type], shape, count, block.subarray(offset));
  });
}

// Bytes by significance -> patterns of bits, of which second differences are stored, column by column.
function columns(Type, shape, count, bytes) {
  const size = Type.BYTES_PER_ELEMENT;
  const rows = shape[0];
  const width = rows ? count / rows : 0;
  const flat = new Uint8Array(count * size);
  for (let plane = 0; plane < size; ++plane)
    for (let k = 0; k < count; ++k) flat[k * size + plane] = bytes[plane * count + k];
  const found = new Type(count);
  if (size === 8) {
    const stored = new BigUint64Array(flat.buffer), to = new BigInt64Array(found.buffer);
    for (let c = 0; c < width; ++c) {
      let value = 0n, step = 0n;
      for (let r = 0; r < rows; ++r) {
        const folded = stored[c * rows + r], second = (folded >> 1n) ^ -(folded & 1n);
        step = r === 0 ? 0n : BigInt.asIntN(64, step + second);
        value = r === 0 ? BigInt.asIntN(64, second) : BigInt.asIntN(64, value + step);
        to[r * width + c] = value;
      }
    }
  } else {
    const stored = new Uint32Array(flat.buffer), to = new Int32Array(found.buffer);
    for (let c = 0; c < width; ++c) {
      let value = 0, step = 0;
      for (let r = 0; r < rows; ++r) {
        const folded = stored[c * rows + r], second = (folded >>> 1) ^ -(folded & 1);
        step = r === 0 ? 0 : (step + second) | 0;
        value = r === 0 ? second | 0 : (value + step) | 0;
        to[r * width + c] = value;
      }
    }
  }
  return found;
}

// Infinite numbers come as text.
export function numbered(change) {
  return { ...change, first: Number(change.first), second: Number(change.second) };
}
