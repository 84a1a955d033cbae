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

function list(names) {
  return names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names[names.length - 1]}`;
}

const row = (array, k) => array.subarray(6 * k, 6 * k + 6);

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
  const task_ = task.rows.length === 6 ? "the full pose" : "the task";
  if (found.lost) {
    const lost = Array.from({ length: found.lost }, (_, k) => direction(row(found.direction, k)));
    parts.push(`${broken.length ? "the tool has lost" : "in this position the tool cannot do"} ${list(lost)}`);
    return `${parts.join("; ")}.`;
  }
  parts.push(`${task_} is ${broken.length ? "still " : ""}possible`);
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
