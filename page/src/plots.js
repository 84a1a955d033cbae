// The tool's error and the joints' rates over time.

import uPlot from "uplot";

const WINDOW = 20; // [s] of live plots
const MOST = 2400; // points
const TITLE = 20, LEGEND = 24; // [px], a line of the legend
const ONE_LINE = 420; // [px] of width that hold it

function axes(colours, units) {
  const line = { stroke: colours.soft, grid: { stroke: colours.grid, width: 1 }, ticks: { stroke: colours.grid, width: 1 }, font: "11px system-ui", labelFont: "11px system-ui" };
  return [
    { ...line, size: 32, label: "time [s]", labelSize: 14, labelGap: 0 },
    { ...line, size: 46, label: units, labelSize: 14, labelGap: 0 },
  ];
}

export class Plot {
  // series: [label, colour, dash] each.
  constructor(box, title, units, series, colours, least) {
    Object.assign(this, { box, title, units, series, least, lines: [[], ...series.map(() => [])] });
    this.draw(colours);
  }

  draw(colours) {
    this.plot?.destroy();
    this.plot = new uPlot(
      {
        title: this.title,
        width: Math.max(this.box.clientWidth, 120),
        height: this.height(),
        pxAlign: 0,
        legend: { show: this.legend, live: false },
        cursor: { drag: { x: false, y: false } },
        scales: { x: { time: false }, y: { range: (_, low, high) => [Math.min(0, low ?? 0), Math.max(this.least, high ?? 0) * 1.05] } },
        axes: axes(colours, this.units),
        series: [{}, ...this.series.map(([label, colour, dash]) => ({ label, stroke: colour, width: 1.5, dash, points: { show: false } }))],
        hooks: {
          draw: [
            (plot) => {
              if (this.cursor === undefined) return;
              const x = plot.valToPos(this.cursor, "x", true);
              const pen = plot.ctx;
              pen.save();
              pen.strokeStyle = colours.bad;
              pen.beginPath();
              pen.moveTo(x, plot.bbox.top);
              pen.lineTo(x, plot.bbox.top + plot.bbox.height);
              pen.stroke();
              pen.restore();
            },
          ],
        },
      },
      this.lines,
      this.box,
    );
  }

  get legend() {
    return this.series.length > 1 && this.series.length <= 4;
  }

  height() {
    return Math.max(this.box.clientHeight - TITLE - (this.legend ? LEGEND * (this.box.clientWidth < ONE_LINE ? this.series.length : 1) : 0), 80);
  }

  size() {
    const width = Math.max(this.box.clientWidth, 120), height = this.height();
    if (Math.abs(width - this.plot.width) > 1 || Math.abs(height - this.plot.height) > 1) this.plot.setSize({ width, height });
  }

  add(time, values) {
    const [times] = this.lines;
    if (times.length && time <= times[times.length - 1]) return;
    this.lines.forEach((line, k) => line.push(k ? values[k - 1] : time));
    let first = 0;
    while (first < times.length - 2 && (times[first] < time - WINDOW || times.length - first > MOST)) ++first;
    if (first > 200 || times.length > MOST + 400) this.lines.forEach((line) => line.splice(0, first));
  }

  show() {
    this.plot.setData(this.lines);
  }

  clear() {
    for (const line of this.lines) line.length = 0;
  }

  whole(lines) {
    this.lines = lines;
    this.show();
  }

  at(time) {
    this.cursor = time;
    this.plot.redraw(false);
  }
}
