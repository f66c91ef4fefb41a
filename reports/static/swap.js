// Parts swapped and tuned in the page: the leg moved anew by the page's integrator, errors, and the lines for the project.
"use strict";
addEventListener("load", () => setTimeout(function () {  // after the page stands: it moves the leg from every release
  const home = document.getElementById("swap-parts"), given = document.getElementById("leg-data");
  if (!home || !given) return;
  const page = JSON.parse(given.textContent), joints = page.leg.joints, replay = page.replay, DEG = 180 / Math.PI;
  const plots = synthPlots.of(home.closest("details"));
  const make = function (tag, properties, parent) {
    const made = Object.assign(document.createElement(tag), properties);
    if (parent) parent.appendChild(made);
    return made;
  };
  const shown = (value, digits) => value.toFixed(digits).replace("-", "−");
  const number = (value) => String(parseFloat(value.toPrecision(4))).replace("-", "−");
  const signed = (value, digits) => (value < 0 ? "−" : "+") + Math.abs(value).toFixed(digits);

  // What acts with these choices: rate times a factor, damper times a factor, free angle as given or so that it rests as wanted.
  function scaled(damper, factor) {
    return damper.speed ? { speed: damper.speed, slope: damper.slope.map((s) => s * factor) } : { rate: damper.rate * factor };
  }
  function freeRotation(name, rate) { const h = page.joints[name].holding; return h.rotation + h.torque / rate; }
  function acting(state, j) {
    const options = page.joints[joints[j].name], damper = options.dampers[state.damper];
    const rate = state.rate;
    const rotation = state.free === null ? (state.own ? joints[j].rotation : freeRotation(joints[j].name, rate)) : joints[j].sign * (state.free - joints[j].zero) / DEG;
    return { rate, rotation, damper: scaled(damper, state.strength), effects: joints[j].effects };
  }
  const fresh = (j) => ({ spring: 0, damper: 0, rate: joints[j].rate, strength: 1, free: null, own: true });
  let states = joints.map((_, j) => fresh(j));
  const chosen = joints.map((_, j) => acting(fresh(j), j));
  const chosenMotions = replay.releases.map((release) => synthLeg.motion(release, chosen));
  const chosenErrors = synthLeg.errors(joints, replay, chosenMotions);

  // ---- controls
  const head = make("div", { className: "tools" }, home);
  const trialLabel = make("label", { textContent: "release shown " }, head), trial = make("select", {}, trialLabel);
  replay.releases.forEach((release, r) => make("option", { value: r, textContent: release.name }, trial));
  const reset = make("button", { type: "button", textContent: "As chosen" }, head);
  const grid = make("div", { className: "swap" }, home);
  const totals = make("p", { className: "totals" }, home);
  totals.setAttribute("role", "status");
  const lines = make("pre", { className: "lines", tabIndex: 0 }, home), code = make("code", {}, lines);
  lines.setAttribute("aria-label", "lines for the project");

  function band(parent, low, high, at, words) {  // the fit's value and 90 % interval on a slider's scale, as shares
    const holder = make("div", { className: "band", title: words }, parent);
    holder.setAttribute("role", "img"); holder.setAttribute("aria-label", words);
    const clip = (x) => Math.min(100, Math.max(0, 100 * x));
    const span = make("span", {}, holder);
    span.style.left = `${clip(low)}%`; span.style.width = `${Math.max(1, clip(high) - clip(low))}%`;
    make("i", {}, holder).style.left = `${clip(at)}%`;
  }
  const WIDE = 4;  // times and parts of the chosen rate that a slider reaches
  const controls = joints.map(function (joint, j) {
    const options = page.joints[joint.name], box = make("fieldset", {}, grid);
    make("legend", { textContent: joint.name }, box);
    const wanted = options.springs[0].rate;
    const springLabel = make("label", { textContent: "spring" }, box), spring = make("select", {}, springLabel);
    options.springs.forEach(function (option, i) {
      if (i && !(option.rate >= wanted / 4 && option.rate <= wanted * 4)) return;  // another leg, whatever its response
      const pieces = [option.part, `${number(option.rate)} N·m/rad${i ? ` (${signed(100 * (option.rate / wanted - 1), 0)} % from the chosen)` : ""}`, `${shown(option.error, 2)}° off`];
      if (option.outer_mm) pieces.push(`Ø${number(option.outer_mm)} mm`);
      if (option.price) pieces.push(option.price);
      make("option", { value: i, textContent: (i ? "" : "chosen: ") + pieces.join(", ") }, spring);
    });
    const springWhole = make("p", { className: "picked-part" }, box);
    const damperLabel = make("label", { textContent: "damper" }, box), damper = make("select", {}, damperLabel);
    options.dampers.forEach(function (option, i) {
      const pieces = [option.part, option.law, `${shown(option.error, 2)}° off`];
      if (option.price) pieces.push(option.price);
      if (option.spring_rate) pieces.push(`with a spring of ${number(option.spring_rate)} N·m/rad`);
      make("option", { value: i, textContent: (i ? "" : "chosen: ") + pieces.join(", ") }, damper);
    });
    const damperWhole = make("p", { className: "picked-part" }, box);
    const fit = joint.fit || {};
    const slide = function (words, low, high) {
      const label = make("label", {}, box), text = make("span", {}, label), input = make("input", { type: "range", min: low, max: high, step: "any" }, label);
      return { text, input, words };
    };
    const rate = slide("spring rate", -1, 1), marks = fit.spring_rate;
    const log = (value) => (Math.log(value / joint.rate) / Math.log(WIDE) + 1) / 2;
    if (marks && marks.interval90) band(box, log(marks.interval90[0]), log(marks.interval90[1]), log(marks.value),
      `fit with ${fit.law}: ${number(marks.value)} N·m/rad, 90 % ${number(marks.interval90[0])} to ${number(marks.interval90[1])}`);
    const strength = slide("damper torque", -1, 1);
    const free = slide("free angle", synthLeg.measured(joint, joint.rotation) - 25, synthLeg.measured(joint, joint.rotation) + 25);
    const angle = fit.free_angle, at = (value) => (value - parseFloat(free.input.min)) / 50;
    if (angle && angle.interval90) band(box, at(angle.interval90[0]), at(angle.interval90[1]), at(angle.value),
      `fit with ${fit.law}: ${shown(angle.value, 2)}°, 90 % ${shown(angle.interval90[0], 2)} to ${shown(angle.interval90[1], 2)}`);
    spring.addEventListener("change", function () {
      Object.assign(states[j], { spring: +spring.value, rate: options.springs[+spring.value].rate, free: null, own: +spring.value === 0 && states[j].damper === 0 });
      solve();
    });
    damper.addEventListener("change", function () {
      const option = options.dampers[+damper.value], state = states[j];
      Object.assign(state, { damper: +damper.value, strength: 1, free: null, own: +damper.value === 0 && state.spring === 0 });
      if (state.spring === 0) state.rate = option.spring_rate || options.springs[0].rate;
      solve();
    });
    rate.input.addEventListener("input", function () { Object.assign(states[j], { rate: joint.rate * WIDE ** parseFloat(rate.input.value), own: false }); later(); });
    strength.input.addEventListener("input", function () { states[j].strength = WIDE ** parseFloat(strength.input.value); later(); });
    free.input.addEventListener("input", function () { states[j].free = parseFloat(free.input.value); later(); });
    return { spring, springWhole, damper, damperWhole, rate, strength, free };
  });
  trial.addEventListener("change", draw);
  reset.addEventListener("click", function () { states = joints.map((_, j) => fresh(j)); solve(); });

  let motions = chosenMotions, waiting = 0, first = true;
  function later() { show(); if (!waiting) waiting = setTimeout(function () { waiting = 0; solve(); }, 30); }
  function solve() {
    const now = joints.map((_, j) => acting(states[j], j));
    if (!first) motions = replay.releases.map((release) => synthLeg.motion(release, now));
    first = false;
    show();
    const errors = synthLeg.errors(joints, replay, motions);
    home.dataset.error = errors.all; home.dataset.chosen = chosenErrors.all;
    const each = joints.map((joint, j) => `${joint.name} ${shown(errors.joints[j], 2)}°`).join(", ");
    const known = page.joints[joints[0].name].springs[0].error;
    const within = page.within ? (errors.all <= page.within ? `, within the allowed ${shown(page.within, 1)}°` : `, beyond the allowed ${shown(page.within, 1)}°`) : "";
    totals.innerHTML = "";
    make("b", { textContent: `${shown(errors.all, 2)}° off the wanted motion (RMS)${within}` }, totals);
    totals.append(` (${signed(errors.all - chosenErrors.all, 2)}° against the chosen parts; ${each}). The chosen parts: ${shown(chosenErrors.all, 2)}° here, ${shown(known, 2)}° by the program.`);
    draw();
    tellLines();
  }
  const picked = (select) => select.selectedOptions.length ? select.selectedOptions[0].textContent : "";  // a narrow list cuts it
  function show() {
    joints.forEach(function (joint, j) {
      const state = states[j], control = controls[j], now = acting(state, j);
      control.spring.value = state.spring; control.damper.value = state.damper;
      control.springWhole.textContent = picked(control.spring); control.damperWhole.textContent = picked(control.damper);
      control.rate.input.value = Math.log(state.rate / joint.rate) / Math.log(WIDE);
      control.rate.text.textContent = `spring rate ${number(state.rate)} N·m/rad`;
      control.strength.input.value = Math.log(state.strength) / Math.log(WIDE);
      control.strength.text.textContent = `damper torque × ${shown(state.strength, 2)}`;
      const angle = synthLeg.measured(joint, now.rotation);
      control.free.input.value = angle;
      control.free.text.textContent = `free angle ${shown(angle, 1)}°${state.free === null ? ", for the wanted rest pose" : ""}`;
    });
  }
  function draw() {
    const r = +trial.value, release = replay.releases[r];
    for (const plot of plots) {
      const j = joints.findIndex((joint) => joint.name === plot.data.joint);
      const series = (motion) => (motion === null ? release.time.map(() => null) : Array.from(motion[j], (q) => synthLeg.measured(joints[j], q)));
      plot.data.time = release.time;
      for (const curve of plot.data.curves) curve.values = curve.name === "wanted" ? release.wanted[j] : series(curve.name === "chosen" ? chosenMotions[r] : motions[r]);
      for (const curve of plot.data.curves) ensure(plot, curve.name);
      synthPlots.redraw(plot);
    }
  }
  function ensure(plot, name) {  // a curve without numbers was not drawn
    if (plot.svg.querySelector(`g[data-curve="${name}"] path`)) return;
    let group = plot.svg.querySelector(`g[data-curve="${name}"]`);
    const NS = "http://www.w3.org/2000/svg";
    if (!group) { group = document.createElementNS(NS, "g"); group.dataset.curve = name; plot.svg.appendChild(group); }
    const path = document.createElementNS(NS, "path");
    const styles = { chosen: ["#d55e00", 1.6, "6 3"], tried: ["#009e73", 2, "2 3"], wanted: ["#0072b2", 1.4, "none"] }[name];
    path.setAttribute("fill", "none"); path.setAttribute("stroke", styles[0]); path.setAttribute("stroke-width", styles[1]);
    if (styles[2] !== "none") path.setAttribute("stroke-dasharray", styles[2]);
    group.appendChild(path);
  }
  function tellLines() {
    const found = [], tuned = [], unnamed = [];
    joints.forEach(function (joint, j) {
      const state = states[j], options = page.joints[joint.name], parts = [];
      if (state.spring) parts.push(`spring: ${options.springs[state.spring].choice}`);
      if (state.damper && options.dampers[state.damper].choice) parts.push(`damper: ${options.dampers[state.damper].choice}`);
      if (state.damper && !options.dampers[state.damper].choice) unnamed.push(`# ${joint.name}: no line names the damper ${options.dampers[state.damper].part}: ${options.dampers[state.damper].unnamed}`);
      if (parts.length) found.push(`    ${joint.name}: {${parts.join(", ")}}`);
      const base = state.spring ? options.springs[state.spring].rate : state.damper && options.dampers[state.damper].spring_rate || options.springs[0].rate;
      if (Math.abs(state.rate / base - 1) > 1e-6 || state.free !== null || state.strength !== 1) {
        const angle = synthLeg.measured(joint, acting(state, j).rotation);
        tuned.push(`# ${joint.name}: spring {rate: ${state.rate.toPrecision(4)} N*m/rad, free_angle: ${angle.toFixed(1)} deg}${state.strength === 1 ? "" : `, damper torque times ${state.strength.toPrecision(3)}`}`);
      }
    });
    const words = [];
    if (found.length) words.push("select:", "  joints:", ...found);
    words.push(...unnamed);
    if (tuned.length) words.push("# tuned by hand; for measured parts write it under measured:", ...tuned);
    code.textContent = words.length ? words.join("\n") : "# as chosen: nothing to change in the project";
  }
  solve();
}, 0));
