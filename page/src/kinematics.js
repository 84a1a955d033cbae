// Where the parts of the arm are, for drawing: products of the placements and of the joints' own motions. Matrices are
// row by row, 16 numbers.

export function multiply(a, b) {
  const c = new Float64Array(16);
  for (let r = 0; r < 4; ++r)
    for (let k = 0; k < 4; ++k) {
      const x = a[4 * r + k];
      if (x !== 0) for (let j = 0; j < 4; ++j) c[4 * r + j] += x * b[4 * k + j];
    }
  return c;
}

function moved(axis, slides, value) {
  const [x, y, z] = axis;
  if (slides) return [1, 0, 0, value * x, 0, 1, 0, value * y, 0, 0, 1, value * z, 0, 0, 0, 1];
  const c = Math.cos(value), s = Math.sin(value), d = 1 - c;
  return [
    c + d * x * x, d * x * y - s * z, d * x * z + s * y, 0,
    d * x * y + s * z, c + d * y * y, d * y * z - s * x, 0,
    d * x * z - s * y, d * y * z + s * x, c + d * z * z, 0,
    0, 0, 0, 1,
  ];
}

const ONE = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

// Points of the base, each joint of the chain and the tool; axes of these joints; the tool's pose.
export function stations(arm, q) {
  const points = [[0, 0, 0]], axes = [];
  let T = ONE;
  for (const link of arm.chain) {
    T = multiply(T, link.placement);
    points.push([T[3], T[7], T[11]]);
    const [x, y, z] = link.axis;
    axes.push([0, 1, 2].map((r) => T[4 * r] * x + T[4 * r + 1] * y + T[4 * r + 2] * z));
    T = multiply(T, moved(link.axis, link.slides, link.factor * q[link.joint] + link.offset));
  }
  T = multiply(T, arm.tool);
  points.push([T[3], T[7], T[11]]);
  return { points, axes, tool: T };
}
