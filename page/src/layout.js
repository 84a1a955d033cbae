// The elements of the viewer, by name.

export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name in element && name !== "list") element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

export function choice(label, options, onchange, attributes = {}) {
  const select = make("select", { ...attributes, onchange: () => onchange(select.value) });
  for (const [value, text] of options) select.append(make("option", { value }, text));
  return [make("label", { className: "row wide" }, make("span", {}, label), select), select];
}

export function slider(label, { min, max, step, value, shown }, oninput) {
  const output = make("output", {}, shown(value));
  const input = make("input", { type: "range", min, max, step, value });
  input.addEventListener("input", () => {
    output.textContent = shown(Number(input.value));
    oninput(Number(input.value));
  });
  return [make("label", { className: "row" }, make("span", {}, label), input, output), input];
}

export function tick(label, checked, onchange) {
  const input = make("input", { type: "checkbox", checked, onchange: () => onchange(input.checked) });
  return make("label", { className: "tick" }, input, label);
}
