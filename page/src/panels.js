// The panels beside the scene. Each function makes one for a viewer, whose methods they call.

import { choice, make, slider, tick } from "./layout.js";
import { OWN } from "./motions.js";
import { lengthOf, number } from "./words.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];
const DELAYS = [0, 0.01, 0.02, 0.04, 0.1, 0.2, 0.5, 1, Infinity]; // [s]
const MOTION_WORDS = { plan: "the task's motion", hold: "hold still", line: "line", circle: "circle", eight: "figure eight", drag: "follow the pointer" };
export const SIZED = ["line", "circle", "eight"];
const KEYS =
  "Space: pause. S: one tick. R: from the beginning. 1 to 9, 0: break or restore a joint. X: a random one. " +
  "H: restore all. Escape leaves a list or a slider; then, in “follow the pointer”, arrow keys and page up and down move the target.";

function seconds(time) {
  if (time === Infinity) return "never";
  return time < 1 ? `${number(1000 * time)} ms` : `${number(time)} s`;
}

export function looks(viewer) {
  const { shown } = viewer;
  const box = (name, label) => tick(label, shown[name], (on) => (shown[name] = on));
  viewer.ghostName = make("span", {}, "healthy arm");
  viewer.ghostBox = tick(viewer.ghostName, shown.ghost, (on) => (shown.ghost = on));
  const view = make("button", { type: "button", onclick: () => viewer.scene.view() }, "view");
  return make("div", { className: "looks" }, box("names", "names"), viewer.ghostBox, box("trail", "paths"), box("lost", "lost directions"), box("ellipsoid", "speeds"), view);
}

export function jointRow(viewer, joint, i) {
  const sign = make("span", { className: "sign" }), name = make("span", { className: "name" }, joint.name);
  const state = make("span", { className: "state" }), value = make("span", { className: "value" });
  const rate = make("i"), worth = make("i");
  const bars = [
    make("span", { className: "bar", title: "how fast it moves, as a share of its limit" }, rate),
    make("span", { className: "bar worth", title: "manipulability that its loss would cost" }, worth),
  ];
  const button = make("button", { type: "button", className: "joint", title: joint.name, onclick: () => viewer.hit(i) }, sign, name, state, value, ...bars);
  return { button, sign, state, value, rate, worth };
}

export function breaking(viewer) {
  const kinds = viewer.task.kinds.map((kind, k) => [k, `${kind.word}: ${kind.meaning}`]);
  const [kindRow] = choice("a click makes it", kinds, (value) => (viewer.kind = Number(value)), { className: "kind" });
  const options = { min: 0, max: DELAYS.length - 1, step: 1, value: 0, shown: (k) => seconds(DELAYS[k]) };
  const [delayRow] = slider("known after", options, (k) => (viewer.delay = DELAYS[k]));
  const button = (name, text, action) => make("button", { type: "button", className: name, onclick: action }, text);
  const buttons = make("div", { className: "buttons" }, button("random", "a random joint", () => viewer.random()), button("heal", "restore all", () => viewer.heal()));
  const legend = make("p", { className: "soft" }, "Upper bar: how fast it moves, as a share of its limit, in the colour of its line below. Lower bar: share of the manipulability that its loss would cost.");
  const list = make("div", { className: "list" }, ...viewer.rows.map((row) => row.button));
  return make("section", { className: "joints" }, make("h2", {}, "Break a joint"), kindRow, delayRow, list, buttons, legend);
}

export function motion(viewer) {
  const { parts, arm } = viewer.task;
  const kinds = [...(parts.length ? ["plan"] : []), ...OWN, "drag"];
  const [row, select] = choice("the target", kinds.map((kind) => [kind, MOTION_WORDS[kind]]), (kind) => viewer.setMotion(kind), { className: "motion" });
  const again = () => viewer.setMotion(viewer.motionKind);
  const { pace } = viewer.task;
  const [sizeRow, size] = slider("size", { min: 0.01, max: 0.4, step: 0.01, value: pace.size, shown: (x) => lengthOf(x * arm.reach) }, again);
  const [timeRow, time] = slider("a round takes", { min: 1, max: 60, step: 0.5, value: pace.seconds, shown: (x) => `${x} s` }, again);
  Object.assign(viewer, { motionSelect: select, sizeInput: size, timeInput: time, shapeRows: [sizeRow, timeRow] });
  viewer.select(kinds[0]);
  return make("section", {}, make("h2", {}, "Motion"), row, sizeRow, timeRow);
}

export function control(viewer) {
  const { laws, nullMotions } = viewer.task;
  Object.assign(viewer, { law: 0, nullMotion: 0, share: 1 });
  const numbered = (options) => options.map(({ label }, k) => [k, label]);
  const [lawRow] = choice("law", numbered(laws), (k) => viewer.settings({ law: Number(k) }), { className: "law" });
  const [nullRow] = choice("spare freedom", numbered(nullMotions), (k) => viewer.settings({ nullMotion: Number(k) }), { className: "null" });
  const [limitRow] = slider("rate limits", { min: 0.05, max: 1, step: 0.05, value: 1, shown: (x) => `${Math.round(100 * x)} %` }, (share) => viewer.settings({ share }));
  limitRow.classList.add("limits");
  return make("section", {}, make("h2", {}, "Controller"), lawRow, nullRow, limitRow);
}

// A setup of one law with the null motion of another setup, and a share of the rate limits. The end of a setup is: the
// null motion's kind, gain, largest rate, failures and n numbers, n flags of rotary joints, and 5 n limits (setup.hpp).
export function setup(task, law, nullMotion, share) {
  const n = task.arm.joints.length, end = 4 + 7 * n;
  const all = Float64Array.from(task.laws[law].setup), other = task.nullMotions[nullMotion].setup;
  all.set(other.subarray(other.length - end, other.length - end + 4 + n), all.length - end);
  for (let i = 0; i < 2 * n; ++i) all[all.length - 5 * n + i] *= share;
  return all;
}

export function notes(viewer) {
  viewer.notesBox = make("div", { className: "soft" }, ...viewer.data.notes.map((note) => make("p", {}, note)));
  const keys = make("details", { className: "soft" }, make("summary", {}, "Keys"), make("p", {}, KEYS));
  const about = `stillreach ${viewer.data.version}: the controller of the C++ core, compiled to WebAssembly, every ${number(1000 * viewer.task.period)} ms.`;
  return make("section", {}, viewer.notesBox, keys, make("p", { className: "soft" }, about));
}

export function transport(viewer) {
  const button = (text, label, action, name) => make("button", { type: "button", ariaLabel: label, title: label, className: name, onclick: action }, text);
  viewer.playButton = button("▶", "play (space)", () => viewer.run(!viewer.playing), "play");
  const options = { min: 0, max: SPEEDS.length - 1, step: 1, value: SPEEDS.indexOf(1), shown: (k) => `× ${SPEEDS[k]}` };
  const [speedRow] = slider("speed", options, (k) => viewer.setPace(SPEEDS[k]));
  viewer.clock = make("span", { className: "clock" });
  const bar = [viewer.playButton, button("▸|", "one tick (S)", () => viewer.step(1), "step"), button("↺", "from the beginning (R)", () => viewer.reset(), "reset"), speedRow, viewer.clock];
  const { runs } = viewer.data;
  if (!runs.length) return make("div", { className: "transport" }, ...bar);
  viewer.slider = make("input", { type: "range", className: "time", min: 0, max: 1, step: "any", value: 0, ariaLabel: "time of the replay" });
  viewer.slider.addEventListener("input", () => viewer.seek(Number(viewer.slider.value)));
  viewer.marks = make("div", { className: "marks" });
  const [runRow] = choice("run", runs.map((run, k) => [k, run.label]), (k) => viewer.chooseRun(Number(k)), { className: "run" });
  viewer.goOnButton = make("button", { type: "button", className: "go-on", onclick: () => viewer.goOn() }, "continue live from here");
  viewer.backButton = make("button", { type: "button", className: "back", onclick: () => viewer.backToReplay() }, "back to the replay");
  const replay = make("div", { className: "replay" }, make("div", { className: "track" }, viewer.slider, viewer.marks), runs.length > 1 ? runRow : null, viewer.goOnButton, viewer.backButton);
  return make("div", { className: "transport" }, ...bar, replay);
}
