"use strict";
// Drag a rectangle to zoom, double-click for the whole; hover or touch reads the nearest point. The drawings are
// complete without this script: it only moves what they hold, and writes new ticks.
(() => {
  const MINUS = "−";
  const number = (v, step) => {
    const size = Math.max(Math.abs(v), Math.abs(step) || 0);
    const text = size !== 0 && (size < 1e-4 || size >= 1e6) ? v.toExponential(2)
      : step ? v.toFixed(Math.max(0, Math.min(12, Math.ceil(-Math.log10(step) - 1e-9)))) : String(+v.toPrecision(4));
    return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", MINUS);
  };
  const ticks = (low, high, log) => {
    if (log && high / low > 4) {
      const found = [], inner = high / low < 200 ? [1, 2, 5] : [1];
      for (let p = Math.floor(Math.log10(low)); p <= Math.log10(high); p++)
        for (const m of inner) if (m * 10 ** p >= low && m * 10 ** p <= high) found.push([m * 10 ** p, 0]);
      return found;
    }
    const raw = (high - low) / 5, power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find((m) => m * power >= raw);
    const found = [];
    for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) found.push([k * step, step]);
    return found;
  };
  class Axis {
    constructor(limits, ends, log) {
      [this.log, this.ends] = [log, ends];
      this.whole = limits.map((v) => this.scaled(v));
      this.now = this.whole;
    }
    scaled(v) { return this.log ? Math.log10(v) : v; }
    value(s) { return this.log ? 10 ** s : s; }
    at(pixel, range = this.now) {
      return range[0] + ((range[1] - range[0]) * (pixel - this.ends[0])) / (this.ends[1] - this.ends[0]);
    }
    pixel(s) { return this.ends[0] + ((this.ends[1] - this.ends[0]) * (s - this.now[0])) / (this.now[1] - this.now[0]); }
    moved(pixel) { return this.pixel(this.at(pixel, this.whole)); }
    zoom(a, b) {
      const [low, high] = [Math.max(Math.min(a, b), this.whole[0]), Math.min(Math.max(a, b), this.whole[1])];
      if (high - low > 1e-6 * (this.whole[1] - this.whole[0])) this.now = [low, high];
    }
  }
  class Plot {
    constructor(svg, group, about) {
      Object.assign(this, { svg, group, about });
      const [left, top, right, bottom] = about.box;
      this.box = about.box;
      this.axes = [new Axis(about.x, [left, right], about.log.includes("x")),
        new Axis(about.y, [bottom, top], about.log.includes("y"))];
      this.ticks = ["xtick", "ytick"].map((name) => [...group.querySelectorAll(`.${name}`)]);
      this.made = [];
      this.parts = [...group.querySelectorAll("[clip-path]")].filter((e) => !e.closest(".xtick, .ytick"))
        .flatMap((e) => (e.tagName === "path" ? [e] : [...e.querySelectorAll("path, use")]))
        .map((e) => ({ e, whole: e.tagName === "use" ? [e.getAttribute("x"), e.getAttribute("y")].map(Number)
          : e.getAttribute("d").match(/[A-Za-z]|-?[\d.]+(?:e-?\d+)?/g).map((t) => (isNaN(t) ? t : Number(t))) }));
      this.series = [...group.querySelectorAll("[data-series]")].map((g) => ({ name: g.dataset.series,
        points: this.parts.filter((p) => g.contains(p.e)).flatMap(({ e, whole }) => {
          const flat = whole.filter((t) => typeof t === "number"), found = [];
          for (let i = 0; i + 1 < flat.length; i += 2) found.push([flat[i], flat[i + 1]]);
          return found;
        }) }));
    }
    holds([x, y]) {
      const [left, top, right, bottom] = this.box;
      return x >= left && x <= right && y >= top && y <= bottom;
    }
    draw() {
      const [x, y] = this.axes;
      for (const { e, whole } of this.parts) {
        if (e.tagName === "use") {
          e.setAttribute("x", x.moved(whole[0]).toFixed(2));
          e.setAttribute("y", y.moved(whole[1]).toFixed(2));
          continue;
        }
        let turn = 0;
        e.setAttribute("d", whole.map((t) => (typeof t === "string" ? t : (turn++ % 2 ? y : x).moved(t).toFixed(2))).join(" "));
      }
      for (const g of this.made) g.remove();
      this.made = [];
      this.axes.forEach((axis, i) => this.label(axis, i));
    }
    label(axis, i) {
      const whole = axis.now === axis.whole;
      for (const g of this.ticks[i]) g.style.display = whole ? "" : "none";
      const model = this.ticks[i].find((g) => g.querySelector("text, use, path"));
      if (whole || !model) return;
      const named = this.ticks[i].some((g) => g.querySelector("text"));
      const pattern = this.ticks[i].find((g) => g.querySelector("text")) || model;
      const use = pattern.querySelector("use"), from = Number(use.getAttribute(i ? "y" : "x"));
      for (const [value, step] of ticks(...axis.now.map((s) => axis.value(s)), axis.log)) {
        const g = pattern.cloneNode(true), shift = axis.pixel(axis.scaled(value)) - from;
        g.setAttribute("transform", i ? `translate(0 ${shift.toFixed(2)})` : `translate(${shift.toFixed(2)} 0)`);
        g.style.display = "";
        if (named) g.querySelector("text").textContent = number(value, step);
        pattern.parentNode.append(g);
        this.made.push(g);
      }
    }
    nearest([x, y]) {
      let best = null, least = 30 ** 2;
      for (const { name, points } of this.series)
        for (const [px, py] of points) {
          const at = [this.axes[0].moved(px), this.axes[1].moved(py)];
          const away = (at[0] - x) ** 2 + (at[1] - y) ** 2;
          if (away < least && this.holds(at)) [best, least] = [{ name, at }, away];
        }
      if (best) best.values = best.at.map((p, i) => this.axes[i].value(this.axes[i].at(p)));
      return best;
    }
  }
  const element = (svg, name, attributes) => {
    const e = document.createElementNS(svg.namespaceURI, name);
    for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
    return e;
  };
  const prepare = (svg) => {
    const groups = svg.querySelectorAll("g.axes"), holder = svg.closest(".picture");
    const plots = JSON.parse(svg.dataset.axes).map((about, i) => new Plot(svg, groups[i], about));
    const dot = element(svg, "circle", { r: 4, class: "dot", visibility: "hidden" });
    const frame = element(svg, "rect", { class: "frame", visibility: "hidden" });
    svg.append(frame, dot);
    const readout = document.createElement("output");
    readout.className = "readout";
    holder.append(readout);
    const place = (event) => {
      const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      return [p.x, p.y];
    };
    const redraw = () => { plots.forEach((p) => p.draw()); dot.setAttribute("visibility", "hidden"); readout.textContent = ""; };
    const zoom = (plot, range) => {
      range.forEach((r, i) => r && plot.axes[i].zoom(...r));
      for (const other of plots) other.axes[0].now = other === plot ? other.axes[0].now : [...plot.axes[0].now];
      redraw();
    };
    const whole = () => { for (const p of plots) for (const a of p.axes) a.now = a.whole; redraw(); };
    const scale = (factor) => zoom(plots.at(-1), plots.at(-1).axes.map((a) => {
      const middle = (a.now[0] + a.now[1]) / 2, half = ((a.now[1] - a.now[0]) / 2) * factor;
      return [middle - half, middle + half];
    }));
    let start = null;
    const drag = (event) => {
      const at = place(event), [left, top, right, bottom] = start.plot.box;
      const inside = [Math.min(Math.max(at[0], left), right), Math.min(Math.max(at[1], top), bottom)];
      const sides = [0, 1].map((i) => [Math.min(start.at[i], inside[i]), Math.max(start.at[i], inside[i])]);
      const large = sides.map(([a, b]) => b - a > 8);
      if (!large[1]) sides[1] = [top, bottom];
      if (!large[0]) sides[0] = [left, right];
      return { sides, large };
    };
    svg.addEventListener("pointerdown", (event) => {
      const at = place(event), plot = plots.find((p) => p.holds(at));
      if (plot && event.button === 0 && event.pointerType !== "touch") {
        start = { at, plot };
        if (event.isTrusted) svg.setPointerCapture(event.pointerId);
        event.preventDefault();
        svg.focus({ preventScroll: true });
      }
    });
    svg.addEventListener("pointermove", (event) => {
      if (start) {
        const { sides: [[a, b], [c, d]], large } = drag(event);
        Object.entries({ x: a, y: c, width: b - a, height: d - c }).forEach(([k, v]) => frame.setAttribute(k, v));
        frame.setAttribute("visibility", large[0] || large[1] ? "visible" : "hidden");
        return;
      }
      const at = place(event), plot = plots.find((p) => p.holds(at)), found = plot && plot.nearest(at);
      dot.setAttribute("visibility", found ? "visible" : "hidden");
      readout.textContent = "";
      if (!found) return;
      dot.setAttribute("cx", found.at[0]);
      dot.setAttribute("cy", found.at[1]);
      const words = plot.about.names.map((n, i) => {
        const [name, unit] = [n.slice(0, n.lastIndexOf(", ")), n.slice(n.lastIndexOf(", ") + 2)];
        return n.includes(", ") ? `${name} ${number(found.values[i])} ${unit}` : `${n} ${number(found.values[i])}`;
      });
      readout.textContent = `${found.name}: ${words.join("; ")}`;
    });
    const end = (event) => {
      frame.setAttribute("visibility", "hidden");
      if (!start) return;
      const { sides, large } = drag(event), { plot } = start;
      start = null;
      if (large[0] || large[1]) zoom(plot, sides.map((s, i) => (large[i] ? s.map((p) => plot.axes[i].at(p)) : null)));
    };
    svg.addEventListener("pointerup", end);
    svg.addEventListener("pointercancel", () => { start = null; frame.setAttribute("visibility", "hidden"); });
    svg.addEventListener("pointerleave", () => { dot.setAttribute("visibility", "hidden"); readout.textContent = ""; });
    svg.addEventListener("dblclick", whole);
    svg.addEventListener("keydown", (event) => {
      const act = { "+": () => scale(0.7), "-": () => scale(1 / 0.7), 0: whole, Escape: whole }[event.key];
      if (act) { act(); event.preventDefault(); }
    });
  };
  for (const svg of document.querySelectorAll("svg[data-axes]")) {
    svg.setAttribute("tabindex", "0");
    for (const kind of ["pointerenter", "focus"]) svg.addEventListener(kind, () => {
      if (!svg.prepared) prepare(svg);
      svg.prepared = true;
    });
  }
  document.body.classList.add("interactive");
})();
