// Time plots: one cursor for all plots of a recording, values under it, zoom, curves on and off, data as CSV, figure as SVG.
// Without this script the drawings stand as they are; each plot's numbers lie beside it as JSON.
"use strict";
(function () {
  const NS = "http://www.w3.org/2000/svg";
  const plots = [];

  function element(name, attributes, parent) {
    const made = document.createElementNS(NS, name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    if (parent) parent.appendChild(made);
    return made;
  }
  function shown(value) {
    if (value === null || !isFinite(value)) return "–";
    const digits = Math.abs(value) >= 100 ? 1 : Math.abs(value) >= 1 ? 2 : 3;
    return value.toFixed(digits).replace("-", "−");
  }
  function nearest(times, time) {
    let low = 0, high = times.length - 1;
    while (high - low > 1) { const middle = (low + high) >> 1; if (times[middle] < time) low = middle; else high = middle; }
    return Math.abs(times[low] - time) <= Math.abs(times[high] - time) ? low : high;
  }
  function scaleX(plot, time) { const [a, b, s, e] = plot.x; return s + (time - a) / (b - a) * (e - s); }
  function scaleY(plot, value) { const [a, b, s, e] = plot.data.y; return s + (value - a) / (b - a) * (e - s); }

  function ticks(low, high, most) {
    let exponent = Math.floor(Math.log10((high - low) / most));
    for (let k = exponent; k < exponent + 3; k++) for (const m of [1, 2, 5]) {
      const step = m * 10 ** k, first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
      if (last - first + 1 <= most) {
        const found = [];
        for (let i = first; i <= last; i++) found.push((i * step).toFixed(Math.max(0, -k)).replace("-", "−"));
        return found;
      }
    }
    return [];
  }

  // Draw the curves anew between plot.x[0] and plot.x[1].
  function redraw(plot) {
    const [low, high] = plot.x, data = plot.data;
    for (const curve of data.curves) {
      const path = plot.svg.querySelector(`g[data-curve="${CSS.escape(curve.name)}"] path`);
      if (!path) continue;
      let text = "", pen = false;
      for (let i = 0; i < data.time.length; i++) {
        const value = curve.values[i];
        if (value === null || data.time[i] < low || data.time[i] > high) { pen = false; continue; }
        const x = scaleX(plot, data.time[i]).toFixed(1), y = scaleY(plot, value).toFixed(1);
        text += curve.dots ? `M${x} ${y}h0` : `${pen ? "L" : "M"}${x} ${y}`;
        pen = true;
      }
      path.setAttribute("d", text || "M0 0");
    }
    const group = plot.svg.querySelector(".x-ticks");
    if (!group) return;
    group.textContent = "";
    const foot = data.y[2];
    for (const tick of ticks(low, high, 5)) {
      const x = scaleX(plot, parseFloat(tick.replace("−", "-")));
      element("line", { x1: x, y1: foot, x2: x, y2: foot + 3, stroke: "#666", "stroke-width": 0.8 }, group);
      element("text", { x, y: foot + 13.5, "text-anchor": "middle", "font-size": 10, fill: "#666" }, group).textContent = tick;
    }
  }

  function zoom(group, low, high) {
    for (const plot of plots) if (plot.group === group) {
      plot.x = [low === null ? plot.data.x[0] : low, low === null ? plot.data.x[1] : high, plot.data.x[2], plot.data.x[3]];
      redraw(plot);
      plot.reset.hidden = low === null;
      if (plot.time !== undefined) place(plot, plot.time);
    }
  }

  // The cursor of one plot at a time; the text under it and for screen readers.
  function place(plot, time) {
    const data = plot.data, i = nearest(data.time, time);
    plot.time = time;
    const inside = time >= plot.x[0] && time <= plot.x[1];
    plot.cursor.style.display = inside ? "" : "none";
    const x = scaleX(plot, data.time[i]);
    plot.line.setAttribute("x1", x); plot.line.setAttribute("x2", x);
    const words = [`${data.time[i].toFixed(3)} s`];
    data.curves.forEach(function (curve, k) {
      const value = curve.values[i], off = plot.off.has(curve.name);
      plot.marks[k].style.display = value === null || off ? "none" : "";
      if (value !== null) { plot.marks[k].setAttribute("cx", x); plot.marks[k].setAttribute("cy", scaleY(plot, value)); }
      if (!off) words.push(`${curve.name} ${shown(value)}${data.unit}`);
    });
    plot.values.textContent = words.join(" · ");
    plot.root.setAttribute("aria-valuenow", data.time[i]);
    plot.root.setAttribute("aria-valuetext", words.join(", "));
  }
  function point(group, time, from) {
    for (const plot of plots) if (plot.group === group) place(plot, time);
    if (from !== "event") document.dispatchEvent(new CustomEvent("synth:time", { detail: { trial: group, time, from: "plot" } }));
  }
  document.addEventListener("synth:time", function (event) {
    if (event.detail.from !== "plot") point(event.detail.trial, event.detail.time, "event");
  });

  function timeAt(plot, event) {
    const box = plot.svg.getBoundingClientRect(), width = plot.svg.viewBox.baseVal.width;
    const [a, b, s, e] = plot.x, x = (event.clientX - box.left) / box.width * width;
    return Math.min(b, Math.max(a, a + (x - s) / (e - s) * (b - a)));
  }

  function follow(plot) {
    let start = null;
    plot.svg.addEventListener("pointermove", function (event) {
      const time = timeAt(plot, event);
      point(plot.group, time);
      if (start === null) return;
      const [from, to] = [start, time].sort((p, q) => p - q).map((t) => scaleX(plot, t));
      plot.span.setAttribute("x", from); plot.span.setAttribute("width", to - from);
    });
    plot.svg.addEventListener("pointerdown", function (event) {
      if (event.pointerType !== "mouse" || event.button !== 0) return;
      start = timeAt(plot, event);
      event.preventDefault();
      plot.root.focus({ preventScroll: true });
      plot.svg.setPointerCapture(event.pointerId);
    });
    function end(event) {
      if (start === null) return;
      const [from, to] = [start, timeAt(plot, event)].sort((p, q) => p - q);
      start = null;
      plot.span.setAttribute("width", 0);
      if (to - from > 0.02 * (plot.x[1] - plot.x[0])) zoom(plot.group, from, to);
    }
    plot.svg.addEventListener("pointerup", end);
    plot.svg.addEventListener("pointercancel", function () { start = null; plot.span.setAttribute("width", 0); });
    plot.svg.addEventListener("dblclick", function () { zoom(plot.group, null, null); });
    plot.root.addEventListener("keydown", function (event) {
      const [low, high] = plot.x, time = plot.time === undefined ? low : plot.time, step = (high - low) / (event.shiftKey ? 10 : 100);
      const span = high - low;
      let moved = null;
      if (event.key === "ArrowRight" || event.key === "ArrowUp") moved = Math.min(high, time + step);
      else if (event.key === "ArrowLeft" || event.key === "ArrowDown") moved = Math.max(low, time - step);
      else if (event.key === "Home") moved = low;
      else if (event.key === "End") moved = high;
      else if (event.key === "+") zoom(plot.group, Math.max(plot.data.x[0], time - span / 4), Math.min(plot.data.x[1], time + span / 4));
      else if (event.key === "-" || event.key === "Escape") zoom(plot.group, null, null);
      else return;
      event.preventDefault();
      if (moved !== null) point(plot.group, moved);
    });
  }

  function save(name, type, text) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type }));
    link.download = name;
    link.click();
    setTimeout(function () { URL.revokeObjectURL(link.href); }, 1000);
  }
  function quoted(text) { return /[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text; }
  function csv(group) {
    const first = group[0].data, heads = ["time [s]"], columns = [first.time];
    for (const plot of group) for (const curve of plot.data.curves) {
      heads.push(`${plot.data.joint} ${curve.name}${plot.data.what === "error" ? " error" : ""} [${plot.data.unit === "°" ? "deg" : plot.data.unit}]`);
      columns.push(plot.data.time === first.time || plot.data.time.length === first.time.length ? curve.values : []);
    }
    const rows = [heads.map(quoted).join(",")];
    first.time.forEach(function (_, i) { rows.push(columns.map((c) => (c[i] === null || c[i] === undefined ? "" : c[i])).join(",")); });
    return rows.join("\n") + "\n";
  }
  function drawing(group) {
    const gap = 12, boxes = group.map((plot) => plot.svg.viewBox.baseVal);
    const width = boxes.reduce((sum, box) => sum + box.width + gap, -gap), height = Math.max(...boxes.map((box) => box.height));
    const sheet = element("svg", { viewBox: `0 0 ${width} ${height}`, width, height, "font-family": "sans-serif" });
    let at = 0;
    group.forEach(function (plot, i) {
      const copy = plot.svg.cloneNode(true);
      copy.querySelectorAll(".cursor").forEach((each) => each.remove());
      copy.removeAttribute("style");
      copy.setAttribute("x", at); copy.setAttribute("width", boxes[i].width); copy.setAttribute("height", boxes[i].height);
      sheet.appendChild(copy);
      at += boxes[i].width + gap;
    });
    return new XMLSerializer().serializeToString(sheet) + "\n";
  }
  function button(words, title, action, parent) {
    const made = document.createElement("button");
    made.type = "button"; made.textContent = words; made.title = title;
    made.addEventListener("click", action);
    parent.appendChild(made);
    return made;
  }

  document.querySelectorAll(".panels").forEach(function (panels, number) {
    const group = panels.dataset.trial || `plots ${number}`, own = [];
    const tools = document.createElement("div");
    tools.className = "tools";
    const file = group.replace(/[^\w-]+/g, "_");
    button("CSV", "Save this figure's numbers", function () { save(`${file}.csv`, "text/csv", csv(own)); }, tools);
    button("SVG", "Save this figure's drawing", function () { save(`${file}.svg`, "image/svg+xml", drawing(own)); }, tools);
    const reset = button("Whole time", "End the zoom (Escape)", function () { zoom(group, null, null); }, tools);
    reset.hidden = true;
    panels.querySelectorAll(":scope > .plot").forEach(function (root) {
      const svg = root.querySelector("svg"), data = JSON.parse(root.querySelector("script").textContent);
      const plot = { root, svg, data, group, reset, x: data.x.slice(), off: new Set(), marks: [] };
      const [, , left, right] = data.x, foot = data.y[2], top = data.y[3];
      plot.cursor = element("g", { class: "cursor" }, svg);
      plot.cursor.style.display = "none";
      plot.span = element("rect", { x: left, y: top, width: 0, height: foot - top, class: "cursor", fill: "#0072b2", "fill-opacity": 0.15 }, svg);
      plot.line = element("line", { x1: left, x2: left, y1: top, y2: foot, stroke: "#666", "stroke-width": 1 }, plot.cursor);
      for (const curve of data.curves) {
        const drawn = svg.querySelector(`g[data-curve="${CSS.escape(curve.name)}"] path`);
        const colour = drawn ? drawn.getAttribute("stroke") : "#222";
        plot.marks.push(element("circle", { r: 3.2, fill: colour, stroke: "#fff", "stroke-width": 1 }, plot.cursor));
      }
      plot.values = document.createElement("div");
      plot.values.className = "values live";
      root.appendChild(plot.values);
      root.tabIndex = 0;
      root.setAttribute("role", "slider");
      root.setAttribute("aria-label", `time cursor of ${data.joint} ${data.what}, ${group}; arrows move it, plus zooms, Escape ends the zoom`);
      root.setAttribute("aria-valuemin", data.x[0]); root.setAttribute("aria-valuemax", data.x[1]); root.setAttribute("aria-valuenow", data.x[0]);
      plots.push(plot); own.push(plot);
      follow(plot);
    });
    if (own.length) panels.after(tools);
  });

  // A legend's entries switch their curves, in the section or figure that the legend stands in.
  document.querySelectorAll(".legend").forEach(function (legend) {
    const home = legend.closest("details.section, figure, header");
    legend.querySelectorAll("span[data-curve]").forEach(function (entry) {
      const name = entry.dataset.curve, own = plots.filter((p) => home && home.contains(p.root) && p.data.curves.some((c) => c.name === name));
      if (!own.length) return;
      const made = document.createElement("button");
      made.type = "button"; made.setAttribute("aria-pressed", "true"); made.title = `Show or hide ${name}`;
      while (entry.firstChild) made.appendChild(entry.firstChild);
      entry.appendChild(made);
      if (entry.dataset.off) {
        made.setAttribute("aria-pressed", "false");
        for (const plot of own) plot.off.add(name);
      }
      made.addEventListener("click", function () {
        const on = made.getAttribute("aria-pressed") !== "true";
        made.setAttribute("aria-pressed", String(on));
        for (const plot of own) {
          plot.svg.querySelectorAll(`g[data-curve="${CSS.escape(name)}"]`).forEach((g) => { g.style.display = on ? "" : "none"; });
          if (on) plot.off.delete(name); else plot.off.add(name);
          if (plot.time !== undefined) place(plot, plot.time);
        }
      });
    });
  });

  // Stick figures follow the cursor of their trial: angles of its plots, turned into the leg's pose.
  document.querySelectorAll("[data-stick]").forEach(function (holder) {
    const stick = JSON.parse(holder.querySelector("script").textContent), svg = holder.querySelector("svg");
    const pose = element("path", { fill: "none", stroke: "#222", "stroke-width": 3, class: "cursor", "stroke-linejoin": "round" }, svg);
    document.addEventListener("synth:time", function (event) {
      if (event.detail.trial !== holder.dataset.stick) return;
      const own = plots.filter((p) => p.group === holder.dataset.stick);
      let turn = stick.tilt, x = 0, z = 0, path = "";
      const put = () => { path += `${path ? "L" : "M"}${(stick.at[0] + stick.scale * x).toFixed(1)} ${(stick.at[1] - stick.scale * z).toFixed(1)}`; };
      put();
      for (const joint of stick.joints) {
        const plot = own.find((p) => p.data.joint === joint.name && p.data.what !== "error");
        const angle = plot ? plot.data.curves[0].values[nearest(plot.data.time, event.detail.time)] : null;
        if (angle === null) return;
        turn += joint.sign * (angle - joint.zero);
        x += joint.length * Math.sin(turn * Math.PI / 180); z -= joint.length * Math.cos(turn * Math.PI / 180);
        put();
      }
      pose.setAttribute("d", path);
    });
  });

  // For other scripts of the page: a plot's curve changed or added to.
  window.synthPlots = {
    of(home) { return plots.filter((plot) => home.contains(plot.root)); },
    redraw(plot) { redraw(plot); if (plot.time !== undefined) place(plot, plot.time); },
  };
})();
