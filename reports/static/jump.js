// The jumping leg: the jump played, and every design of the sweep under the pointer, motors as choices.
"use strict";
(function () {
  const NS = "http://www.w3.org/2000/svg";
  const make = function (tag, properties, parent) {
    const made = Object.assign(document.createElement(tag), properties);
    if (parent) parent.appendChild(made);
    return made;
  };
  const draw = function (tag, attributes, parent) {
    const made = document.createElementNS(NS, tag);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    parent.appendChild(made);
    return made;
  };

  function player(home, jump) {
    const panel = make("div", { className: "player live" }), W = 460, H = 330, poses = jump.poses, DEG = Math.PI / 180;
    const svg = draw("svg", { viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": "the jumping leg at the time of the slider" }, panel);
    const tools = make("div", { className: "tools" }, panel);
    const play = make("button", { type: "button", textContent: "▶ Play" }, tools);
    const slowLabel = make("label", { textContent: "slowed by " }, tools), slow = make("select", {}, slowLabel);
    for (const times of [1, 5, 20]) make("option", { value: times, textContent: `${times}×`, selected: times === 20 }, slow);
    const label = make("label", { className: "slide", textContent: "time " }, tools);
    const slider = make("input", { type: "range", min: poses[0][0], max: poses[poses.length - 1][0], step: "any", value: poses[0][0] }, label);
    const words = make("output", {}, tools);
    const top = Math.max(...poses.map((p) => p[1])) + 0.06, scale = Math.min((H - 40) / top, (W - 40) / (2.2 * (jump.upper + jump.lower)));
    const ground = H - 24, x = (m) => W / 2 + m * scale, y = (m) => ground - m * scale;
    draw("line", { x1: 0, x2: W, y1: ground, y2: ground, stroke: "#666", "stroke-width": 2 }, svg);
    for (let k = 0; k * 0.05 < top; k++) {
      draw("line", { x1: 0, x2: 8, y1: y(k * 0.05), y2: y(k * 0.05), stroke: "#666" }, svg);
      if (k && k % 2 === 0) draw("text", { x: 11, y: y(k * 0.05) + 4, "font-size": 11, fill: "#666" }, svg).textContent = `${(k * 5).toFixed(0)} cm`;
    }
    const body = draw("rect", { height: 5, fill: "#666" }, svg), lines = [];
    for (let k = 0; k < 2; k++) lines.push([
      draw("path", { fill: "none", stroke: "#0072b2", "stroke-width": 5, "stroke-linejoin": "round", "stroke-linecap": "round" }, svg),
      draw("path", { fill: "none", stroke: "#d55e00", "stroke-width": 5, "stroke-linecap": "round" }, svg),
    ]);
    function at(time) {
      let k = 1;
      while (k < poses.length - 1 && poses[k][0] < time) k++;
      const share = Math.min(1, Math.max(0, (time - poses[k - 1][0]) / (poses[k][0] - poses[k - 1][0])));
      return poses[k].map((b, i) => poses[k - 1][i] + share * (b - poses[k - 1][i]));
    }
    function show(time) {
      const [, height, upper, end, lower] = at(time);
      body.setAttribute("x", x(-jump.spacing / 2) - 4); body.setAttribute("width", jump.spacing * scale + 8); body.setAttribute("y", y(height) - 5);
      [-1, 1].forEach(function (side, k) {
        let px = side * jump.spacing / 2, py = height;
        const pieces = jump.split ? [[jump.upper / 2, upper], [jump.upper / 2, end], [jump.lower, -lower]] : [[jump.upper, upper], [jump.lower, -lower]];
        let text = `M${x(px)} ${y(py)}`;
        pieces.forEach(function ([length, angle], i) {
          const last = i === pieces.length - 1;
          if (last) lines[k][0].setAttribute("d", text);
          const start = `M${x(px)} ${y(py)}`;
          px += side * length * Math.sin(angle * DEG); py -= length * Math.cos(angle * DEG);
          if (last) lines[k][1].setAttribute("d", `${start}L${x(px)} ${y(py)}`); else text += `L${x(px)} ${y(py)}`;
        });
      });
      slider.value = time;
      words.textContent = `${(1000 * time).toFixed(0)} ms${jump.takeoff !== null && time >= jump.takeoff ? ", in flight" : ", pushing"}`;
      slider.setAttribute("aria-valuetext", words.textContent);
    }
    let playing = null;
    const stop = function () { if (playing !== null) { cancelAnimationFrame(playing); playing = null; play.textContent = "▶ Play"; } };
    const tell = function (time) { document.dispatchEvent(new CustomEvent("synth:time", { detail: { trial: "jump", time, from: "leg" } })); };
    slider.addEventListener("input", function () { stop(); show(+slider.value); tell(+slider.value); });
    play.addEventListener("click", function () {
      if (playing !== null) { stop(); return; }
      const first = poses[0][0], last = poses[poses.length - 1][0], begun = performance.now();
      play.textContent = "■ Stop";
      (function step() {
        const time = first + (performance.now() - begun) / 1000 / +slow.value;
        show(Math.min(time, last)); tell(Math.min(time, last));
        if (time >= last) { playing = null; play.textContent = "▶ Play"; return; }
        playing = requestAnimationFrame(step);
      })();
    });
    document.addEventListener("synth:time", function (event) {
      if (event.detail.trial === "jump" && event.detail.from === "plot") { stop(); show(event.detail.time); }
    });
    home.prepend(panel);
    home.classList.add("turning");
    show(poses[0][0]);
  }

  const SHADES = ["#f7fbff", "#deebf7", "#c6dbef", "#9ecae1", "#6baed6", "#4292c6", "#2171b5", "#08519c", "#08306b"];
  function designs(home, data) {
    const panel = make("div", { className: "designs live" }, home), tools = make("div", { className: "tools" }, panel);
    const family = (name) => name.replace(/\s*[\d.]+:1$/, "");
    const families = [...new Set(data.designs.map((d) => family(d[0])))];
    const label = make("label", { textContent: "motor " }, tools), choice = make("select", {}, label);
    families.forEach((name) => make("option", { value: name, textContent: name }, choice));
    const heightOf = (d) => (data.shown === "total height" ? d[7] : d[3]) || 0;
    const highest = data.designs.reduce((a, b) => (heightOf(b) > heightOf(a) ? b : a));
    choice.value = family(data.chosen[0] === null ? highest[0] : data.chosen[0]);
    const shownLabel = make("label", { textContent: "show " }, tools), kind = make("select", {}, shownLabel);
    const kinds = [["clearance", 3, "cm", 100], ["relative height", 6, "", 1], ["total height", 7, "cm", 100], ["energy", 8, "J", 1], ["peak gear torque", 9, "N·m", 1], ["peak current", 10, "A", 1]];
    kinds.forEach(([words], i) => make("option", { value: i, textContent: words, selected: words === data.shown }, kind));
    const figure = make("div", { className: "map" }, panel), summary = make("p", { className: "summary" }, panel);
    summary.setAttribute("aria-live", "polite");
    function tell(d) {
      const cm = (v) => (v === null ? "–" : (100 * v).toFixed(1));
      let words = `${d[0]}, ${(1000 * d[2]).toFixed(0)} mm links: ${data.shown === "total height" ? `total height ${cm(d[7])} cm, ` : ""}clearance ${cm(d[3])} cm`;
      if (d[4] !== null) words += ` (90 %: ${cm(d[4])} to ${cm(d[5])})`;
      words += `, ${data.relative} over link length ${d[6] === null ? "–" : d[6].toFixed(3)}, energy ${d[8] === null ? "–" : d[8].toFixed(2)} J, gear torque ${d[9] === null ? "–" : d[9].toFixed(3)} N·m, current ${d[10] === null ? "–" : d[10].toFixed(2)} A`;
      if (d[12]) words += `. ${d[12]}`;
      summary.textContent = words + (isChosen(d) ? " — the chosen design." : ".");
    }
    const isChosen = (d) => d[0] === data.chosen[0] && Math.abs(d[2] - data.chosen[1]) < 1e-6;
    function paint() {
      figure.textContent = "";
      const own = data.designs.filter((d) => family(d[0]) === choice.value), [words, column, unit, times] = kinds[+kind.value];
      const ratios = [...new Set(own.map((d) => d[1]))].sort((a, b) => b - a), lengths = [...new Set(own.map((d) => d[2]))].sort((a, b) => a - b);
      const most = Math.max(1e-9, ...data.designs.map((d) => d[column] || 0)), left = 62, w = 560, high = 22, cell = (w - left) / lengths.length, h = ratios.length * high + 44;
      const svg = draw("svg", { viewBox: `0 0 ${w} ${h}`, tabindex: 0, role: "application", "aria-label": `${words} by gear ratio and link length, ${choice.value}; arrows move over the designs` }, figure);
      svg.style.maxWidth = "620px"; svg.style.minWidth = "340px";
      const cells = new Map();
      own.forEach(function (d) {
        const i = ratios.indexOf(d[1]), k = lengths.indexOf(d[2]), value = d[column];
        const shade = value === null || value <= 0 ? "none" : SHADES[Math.min(8, Math.floor(value / most * 9))];
        const box = draw("rect", { x: left + k * cell, y: i * high, width: cell, height: high, fill: shade, stroke: "#d4d8dd", "stroke-width": 0.6, "pointer-events": "all" }, svg);
        const value1 = value === null ? "–" : (value * times).toFixed(times === 100 ? 1 : 2);
        if (cell > 26) draw("text", { x: left + (k + 0.5) * cell, y: i * high + 15, "font-size": 9, "text-anchor": "middle", class: "cell", fill: shade === "none" ? "#666" : SHADES.indexOf(shade) > 5 ? "#ffffff" : "#111111", "pointer-events": "none" }, svg).textContent = value1;
        if (!d[11]) draw("path", { d: `M${left + k * cell + 2} ${i * high + high - 2}l6 0l-6 -6z`, fill: "#d55e00", "pointer-events": "none" }, svg);
        if (data.front.some((f) => f[0] === d[0] && Math.abs(f[1] - d[2]) < 1e-6)) draw("circle", { cx: left + (k + 1) * cell - 5, cy: i * high + 5, r: 2.6, fill: "#d55e00", stroke: "#fff", "stroke-width": 0.8, "pointer-events": "none" }, svg);
        if (isChosen(d)) draw("rect", { x: left + k * cell + 1, y: i * high + 1, width: cell - 2, height: high - 2, fill: "none", stroke: "#d55e00", "stroke-width": 2.5, "pointer-events": "none" }, svg);
        box.addEventListener("pointerenter", () => point(i, k));
        cells.set(`${i} ${k}`, d);
      });
      ratios.forEach((r, i) => { draw("text", { x: left - 5, y: i * high + 15, "font-size": 10, "text-anchor": "end", fill: "#666" }, svg).textContent = `${r.toFixed(0)}:1`; });
      const every = Math.ceil(lengths.length / 9);
      lengths.forEach((l, k) => { if (k % every === 0) draw("text", { x: left + (k + 0.5) * cell, y: ratios.length * high + 14, "font-size": 10, "text-anchor": "middle", fill: "#666" }, svg).textContent = String(+(1000 * l).toPrecision(4)); });
      draw("text", { x: left + (w - left) / 2, y: h - 6, "font-size": 11, "text-anchor": "middle", fill: "#222" }, svg).textContent = `upper link [mm]; ${words}${unit ? ` [${unit}]` : ""}`;
      const mark = draw("rect", { width: cell, height: high, fill: "none", stroke: "#222", "stroke-width": 2, "pointer-events": "none", display: "none" }, svg);
      let here = [0, 0];
      function point(i, k) {
        if (!cells.has(`${i} ${k}`)) return;
        here = [i, k];
        mark.setAttribute("x", left + k * cell); mark.setAttribute("y", i * high); mark.removeAttribute("display");
        tell(cells.get(`${i} ${k}`));
      }
      svg.addEventListener("keydown", function (event) {
        const move = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
        if (!move) return;
        event.preventDefault();
        point(here[0] + move[0], here[1] + move[1]);
      });
      for (const [place, d] of cells) if (data.chosen[0] === null ? d === highest : isChosen(d)) point(...place.split(" ").map(Number));
    }
    choice.addEventListener("change", paint);
    kind.addEventListener("change", paint);
    paint();
  }

  const jump = document.getElementById("jump-data"), all = document.getElementById("designs-data");
  const stage = document.getElementById("jump-player"), map = document.getElementById("designs-map");
  if (jump && stage) player(stage, JSON.parse(jump.textContent));
  if (all && map) {
    designs(map, JSON.parse(all.textContent));
    if (map.nextElementSibling) map.nextElementSibling.classList.add("still");
    const framed = JSON.parse(all.textContent).chosen[0] === null ? "No design is within its limits, so none is chosen; " : "Framed: the chosen design; dots: designs of the Pareto front; ";
    const key = make("p", { className: "small soft live", textContent: framed + "triangles: designs that cannot be built, with the reason at the pointer." });
    map.appendChild(key);
  }
})();
