// Sentences about what the arm does.

export function number(value, digits = 3) {
  if (!Number.isFinite(value)) return value > 0 ? "none" : "-none";
  if (Math.abs(value) < 1e-6) return "0";
  return Math.abs(value) >= 1000 ? Math.round(value).toLocaleString("en") : String(Number(value.toPrecision(digits)));
}

export function lengthOf(metres) {
  return Math.abs(metres) >= 1 ? `${number(metres)} m` : `${number(1000 * metres)} mm`;
}

export function angleOf(radians) {
  return `${number((radians * 180) / Math.PI)}°`;
}

export function valueOf(value, unit, rate = false) {
  const text = unit === "rad" ? `${number((value * 180) / Math.PI)}°` : `${number(1000 * value)} mm`;
  return rate ? `${text}/s` : text;
}

const AXES = ["x", "y", "z"];
const SMALL = 0.25; // parts of a direction below this share of its largest one are left out

// "z", or "(0.71, 0, 0.71)"; the largest component is positive.
function axis(part) {
  const size = Math.max(...part.map(Math.abs));
  const main = part.findIndex((x) => Math.abs(x) === size);
  if (part.every((x, r) => r === main || Math.abs(x) <= SMALL * size)) return AXES[main];
  return `(${part.map((x) => number(Math.sign(part[main]) * (Math.abs(x) < 0.005 ? 0 : x), 2)).join(", ")})`;
}

// A direction of the tool, six numbers: "motion along z", "rotation about (0.71, 0, 0.71)", or both.
export function direction(twist) {
  const v = Array.from(twist.slice(0, 3)), w = Array.from(twist.slice(3, 6));
  const [moves, turns] = [v, w].map((part) => Math.max(...part.map(Math.abs)));
  const parts = [];
  if (moves > SMALL * turns) parts.push(`motion along ${axis(v)}`);
  if (turns > SMALL * moves) parts.push(`rotation about ${axis(w)}`);
  return parts.join(" with ");
}

const FAR = 0.01, FAR_TURN = 0.035; // of the reach, [rad]: so far from its target that it is said

function list(names) {
  return names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names[names.length - 1]}`;
}

const row = (array, k) => array.subarray(6 * k, 6 * k + 6);
const rowsOf = (array) => Array.from({ length: array.length / 6 }, (_, k) => Array.from(row(array, k)));

// The directions among some that are at right angles to others: unit vectors.
function besides(some, others) {
  const basis = [], found = [];
  const take = (given, kept) => {
    let v = given;
    for (const known of basis) {
      const along = known.reduce((sum, x, r) => sum + x * v[r], 0);
      v = v.map((x, r) => x - along * known[r]);
    }
    const size = Math.hypot(...v);
    if (size < 0.1) return;
    basis.push(v.map((x) => x / size));
    kept?.push(basis[basis.length - 1]);
  };
  others.forEach((v) => take(v));
  some.forEach((v) => take(v, found));
  return found;
}

// Directions that faults took, and those that this position takes of an arm that has them all elsewhere.
export function missing(found, task) {
  const never = rowsOf(found.never);
  return [...besides(rowsOf(found.direction), never), ...(task.never ? [] : never)];
}

// What is broken, what that costs, and what the next loss would cost. Costs are those of the true faults.
export function status(found, task) {
  const names = task.arm.joints.map((joint) => joint.name);
  const { health } = task.words;
  const broken = names.map((_, i) => i).filter((i) => found.health[i] !== 0);
  const missed = broken.filter((i) => found.known[i] !== found.health[i]).map((i) => names[i]);
  const mistaken = names.filter((_, i) => found.health[i] === 0 && found.known[i] !== 0);
  const parts = [broken.length ? list(broken.map((i) => `${names[i]} ${health[found.health[i]]}`)) : "All joints work"];
  if (missed.length) parts.push(`the controller does not know about ${list(missed)}`);
  if (mistaken.length) parts.push(`the controller takes ${list(mistaken)} for broken`);
  const rows = task.rows.length, has = rows - task.never;
  const what = task.never ? `motion in the ${has === 1 ? "one direction" : `${has} directions`} of this arm` : rows === 6 ? "the full pose" : "the task";
  const never = rowsOf(found.never), lost = besides(rowsOf(found.direction), never);
  const far = found.off[0] > FAR * task.arm.reach || found.off[1] > FAR_TURN;
  if (far) parts.push(`the tool is ${lengthOf(found.off[0])} and ${angleOf(found.off[1])} from its target`);
  if (never.length > task.never) {
    if (task.never) parts.push(`in this position it has ${never.length - task.never} of its ${has} directions less`);
    else parts.push(`in this position the tool cannot do ${list(never.map(direction))}`);
  }
  if (lost.length) parts.push(`the tool has lost ${list(lost.map(direction))}`);
  if (lost.length || never.length > task.never) return `${parts.join("; ")}.`;
  const able = far && !task.never ? `motion in every direction${rows === 6 ? "" : " of the task"}` : what;
  parts.push(`${able} is ${broken.length ? "still " : ""}possible${far ? " here" : ""}`);
  const critical = names.map((_, i) => i).filter((i) => found.costs[i] > 0);
  const next = broken.length ? "next " : "";
  if (critical.length) {
    const [first, ...others] = critical;
    const also = others.length ? `; losing ${others.length > 2 ? `any of ${others.length} other joints` : list(others.map((i) => names[i]))} would cost a direction, too` : "";
    parts.push(`losing ${names[first]} ${next}would cost ${direction(row(found.cost, first))}${also}`);
  } else {
    const working = names.map((_, i) => i).filter((i) => found.health[i] === 0);
    const most = working.reduce((a, b) => (found.relative[b] < found.relative[a] ? b : a), working[0]);
    if (most !== undefined) parts.push(`any one ${broken.length ? "more " : ""}joint can fail; ${names[most]} would cost most`);
  }
  return `${parts.join("; ")}.`;
}

// The flags of a tick.
export function flags(bits, task) {
  const found = task.words.status.filter(([bit]) => bits & bit).map(([, word]) => word);
  return found.length ? found.join(", ") : "no limit active";
}
