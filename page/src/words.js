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

const AXES = ["along x", "along y", "along z", "about x", "about y", "about z"];

// A direction of the tool in words: "motion along z", "rotation about (0.71, 0, 0.71)".
export function direction(twist) {
  const size = Math.max(...twist.map(Math.abs));
  const main = twist.findIndex((x) => Math.abs(x) === size);
  const others = twist.filter((x, r) => r !== main && Math.abs(x) > 0.25 * size);
  const what = main < 3 ? "motion" : "rotation";
  if (!others.length) return `${what} ${AXES[main]}`;
  const part = twist.slice(main < 3 ? 0 : 3, main < 3 ? 3 : 6);
  const sign = Math.sign(twist[main]) || 1;
  const inPlace = others.every((x) => Array.from(part).includes(x));
  const axis = Array.from(part, (x) => number(sign * x, 2)).join(", ");
  return `${what} ${main < 3 ? "along" : "about"} (${axis})${inPlace ? "" : ", combined with the other kind"}`;
}

function list(names) {
  return names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names[names.length - 1]}`;
}

// What is broken, what that costs, and what the next loss would.
export function status(found, task) {
  const names = task.arm.joints.map((joint) => joint.name);
  const { health } = task.words;
  const failed = names.map((name, i) => ({ name, i })).filter(({ i }) => found.health[i] !== 0);
  const unknown = failed.filter(({ i }) => found.health[i] !== found.known[i]);
  const said = failed.map(({ name, i }) => `${name} ${health[found.health[i]]}`);
  const parts = [said.length ? list(said) : "All joints work"];
  if (unknown.length) parts.push(`the controller does not know of ${list(unknown.map(({ name }) => name))}`);
  if (found.lost) parts.push(`the tool has lost ${direction(Array.from(found.direction.subarray(0, 6)))}`);
  else {
    const rows = task.rows.length === 6 ? "the full pose" : "the task";
    parts.push(`${rows} is ${failed.length ? "still " : ""}possible`);
    const critical = names.filter((_, i) => found.costs[i] > 0);
    if (critical.length) {
      const worst = names.indexOf(critical[0]);
      const cost = direction(Array.from(found.cost.subarray(6 * worst, 6 * worst + 6)));
      const which = critical.length > 3 ? "any of " + critical.length + " joints" : critical.join(" or ");
      parts.push(`losing ${which} ${failed.length ? "next " : ""}would cost ${cost}`);
    } else if (task.rows.length) {
      const working = names.map((_, i) => i).filter((i) => found.known[i] === 0);
      const least = working.reduce((a, b) => (found.relative[b] < found.relative[a] ? b : a), working[0]);
      if (least !== undefined) parts.push(`any one more can go; ${names[least]} would be missed most`);
    }
  }
  return `${parts.join("; ")}.`;
}

// The flags of a tick.
export function flags(bits, task) {
  const found = task.words.status.filter(([bit]) => bits & bit).map(([, word]) => word);
  return found.length ? found.join(", ") : "no limit active";
}
