// The leg in three dimensions: joints that turn by sliders or play a response, with what springs, dampers and stops then do.
// Needs three.js, the integrator's damper torque, the page's data and the GLB; without WebGL the picture stays.
"use strict";
addEventListener("load", () => setTimeout(async function () {  // after the page stands with its picture
  const home = document.getElementById("leg3d"), packed = document.getElementById("leg-glb"), given = document.getElementById("leg-data");
  if (!home || !packed || !given || !packed.textContent.trim()) return;
  const page = JSON.parse(given.textContent), joints = page.leg.joints, n = joints.length, DEG = 180 / Math.PI;

  async function unpacked() {
    const text = atob(JSON.parse(packed.textContent)), bytes = Uint8Array.from(text, (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).arrayBuffer();
  }
  // The GLB that the design has written: a named mesh a part, one primitive each, no transforms (glTF 2.0, chapter 4).
  function meshes(buffer) {
    const view = new DataView(buffer), size = view.getUint32(12, true);
    const gltf = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 20, size))), start = 28 + size;
    const kinds = { 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
    const read = function (index) {
      const accessor = gltf.accessors[index], part = gltf.bufferViews[accessor.bufferView];
      const width = { SCALAR: 1, VEC3: 3 }[accessor.type];
      return kinds[accessor.componentType].from(new kinds[accessor.componentType](buffer.slice(
        start + (part.byteOffset || 0) + (accessor.byteOffset || 0)), 0, accessor.count * width));
    };
    return gltf.nodes.filter((node) => node.mesh !== undefined).map(function (node) {
      const primitive = gltf.meshes[node.mesh].primitives[0], material = (gltf.materials || [])[primitive.material] || {};
      return { name: node.name, position: read(primitive.attributes.POSITION), index: read(primitive.indices),
        colour: (material.pbrMetallicRoughness || {}).baseColorFactor || [0.6, 0.6, 0.6, 1] };
    });
  }

  // Where each joint stands and how each link is turned, for measured angles in degrees; m and rad.
  function frames(angles) {
    let turn = page.leg.tilt / DEG, x = 0, y = 0;
    const at = [], turns = [turn];
    joints.forEach(function (joint, j) {
      at.push([x, y]);
      turn += joint.sign * (angles[j] - joint.zero) / DEG;
      turns.push(turn);
      x += joint.length * Math.sin(turn); y -= joint.length * Math.cos(turn);
    });
    return { at, turns };
  }
  const restAngles = joints.map((joint) => joint.rest), rest = frames(restAngles);

  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
  } catch (error) { return; }
  const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(30, 1, 0.01, 20);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8a99, 2.2));
  const sun = new THREE.DirectionalLight(0xffffff, 2.0);
  sun.position.set(0.6, 1, 1.2); scene.add(sun);
  const cut = new THREE.Plane(new THREE.Vector3(0, 0, -1), 1e3);
  const loaded = meshes(await unpacked()), known = new Map(page.parts.map((part) => [part.name, part]));
  const bodies = loaded.map(function (found) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(found.position, 3));
    geometry.setIndex(new THREE.BufferAttribute(found.index, 1));
    geometry.computeBoundingBox(); geometry.computeBoundingSphere();
    const material = new THREE.MeshLambertMaterial({ flatShading: true, side: THREE.DoubleSide, clippingPlanes: [cut] });
    material.color.setRGB(found.colour[0], found.colour[1], found.colour[2], "srgb");
    const mesh = new THREE.Mesh(geometry, material), part = known.get(found.name) || { name: found.name, files: [] };
    mesh.matrixAutoUpdate = false; mesh.frustumCulled = false;
    scene.add(mesh);
    const joint = Math.max(0, joints.findIndex((each) => each.name === part.joint));
    const centre = geometry.boundingBox.getCenter(new THREE.Vector3());
    return { mesh, part, joint, body: joint + (part.moves_with === "lower" ? 1 : 0), centre };
  });

  // A spring is twisted along its axis: what lies at the upper arm stays, what lies at the lower arm turns with the joint.
  bodies.filter((b) => b.part.moves_with === "spring").forEach(function (b) {
    const original = b.mesh.geometry.attributes.position.array.slice(), [hx, hy] = rest.at[b.joint], count = original.length / 3;
    const radius = [];
    for (let i = 0; i < count; i++) radius.push(Math.hypot(original[3 * i] - hx, original[3 * i + 1] - hy));
    const middle = radius.slice().sort((p, q) => p - q)[count >> 1], box = b.mesh.geometry.boundingBox, half = (box.min.z + box.max.z) / 2;
    const ends = [0, 1].map(() => ({ x: 0, y: 0, z: 0, count: 0 }));
    for (let i = 0; i < count; i++) if (radius[i] > 1.35 * middle) {
      const end = ends[original[3 * i + 2] > half ? 1 : 0];
      end.x += original[3 * i]; end.y += original[3 * i + 1]; end.z += original[3 * i + 2]; end.count++;
    }
    for (const end of ends) if (end.count) { end.x /= end.count; end.y /= end.count; end.z /= end.count; }
    const shafts = (side) => bodies.filter((o) => o.joint === b.joint && o.part.family === "cap" && o.part.moves_with === side);
    const near = (end, side) => Math.min(...shafts(side).map((o) => Math.hypot(o.centre.x - end.x, o.centre.y - end.y)));
    const share = new Float32Array(count).fill(0.5);
    if (ends[0].count && ends[1].count && shafts("upper").length && shafts("lower").length) {
      const firstIsUpper = near(ends[0], "upper") + near(ends[1], "lower") < near(ends[0], "lower") + near(ends[1], "upper");
      for (let i = 0; i < count; i++) {
        const arm = radius[i] > 1.35 * middle, z = original[3 * i + 2];
        const along = arm ? (z > half ? 1 : 0) : Math.min(1, Math.max(0, (z - ends[0].z) / (ends[1].z - ends[0].z)));
        share[i] = firstIsUpper ? along : 1 - along;
      }
    }
    b.twist = function (angle) {
      const moved = b.mesh.geometry.attributes.position;
      for (let i = 0; i < count; i++) {
        const c = Math.cos(share[i] * angle), s = Math.sin(share[i] * angle), x = original[3 * i] - hx, y = original[3 * i + 1] - hy;
        moved.array[3 * i] = hx + c * x - s * y; moved.array[3 * i + 1] = hy + s * x + c * y;
      }
      moved.needsUpdate = true;
      b.mesh.geometry.computeBoundingSphere();
    };
  });

  // ---- what stands around it
  const make = function (tag, properties, parent) {
    const made = Object.assign(document.createElement(tag), properties);
    if (parent) parent.appendChild(made);
    return made;
  };
  const panel = make("div", { className: "panel3d live" });
  const canvas = renderer.domElement;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "The leg in three dimensions. Drag or arrow keys turn it, wheel or plus and minus zoom; a click on a part shows its description.");
  panel.appendChild(canvas);
  const said = make("p", { className: "picked", textContent: "Drag to turn, click a part for its description." }, panel);
  said.setAttribute("aria-live", "polite");
  const tools = make("div", { className: "tools" }, panel);
  const play = make("button", { type: "button", textContent: "▶ Play" }, tools);
  const trialLabel = make("label", { textContent: "release " }, tools), trials = make("select", {}, trialLabel);
  const kindLabel = make("label", { textContent: "as " }, tools), kinds = make("select", {}, kindLabel);
  const slider = function (words, low, high, value, parent) {
    const label = make("label", { className: "slide", textContent: words + " " }, parent);
    return make("input", { type: "range", min: low, max: high, step: "any", value }, label);
  };
  const explode = slider("explode", 0, 1, 0, tools), section = slider("cut", 0, 1, 0, tools);
  const back = make("button", { type: "button", textContent: "At rest" }, tools);
  const sliders = make("div", { className: "joints3d" }, panel);
  const list = make("details", { className: "parts3d" }, panel);
  make("summary", { textContent: `${bodies.length} parts: hide or show` }, list);
  const boxes = make("div", { className: "boxes" }, list);
  home.querySelectorAll("img").forEach((picture) => picture.classList.add("poster"));
  home.prepend(panel);

  const shown = (value, digits) => (value === null || !isFinite(value) ? "–" : value.toFixed(digits).replace("-", "−"));
  const NS = "http://www.w3.org/2000/svg";
  function small(parent, words, points, labels) {
    const xs = points.map((p) => p[0]), ys = points.map((p) => p[1]), w = 150, h = 62;
    const x0 = Math.min(...xs), x1 = Math.max(...xs), y0 = Math.min(0, ...ys), y1 = Math.max(0, ...ys);
    const sx = (x) => 4 + (Math.min(x1, Math.max(x0, x)) - x0) / (x1 - x0 || 1) * (w - 8), sy = (y) => h - 14 - (Math.min(y1, Math.max(y0, y)) - y0) / (y1 - y0 || 1) * (h - 20);
    const svg = document.createElementNS(NS, "svg");
    svg.setAttribute("viewBox", `0 0 ${w} ${h}`); svg.setAttribute("role", "img"); svg.setAttribute("aria-label", words);
    const put = function (tag, attributes, text) {
      const made = document.createElementNS(NS, tag);
      for (const key in attributes) made.setAttribute(key, attributes[key]);
      if (text) made.textContent = text;
      svg.appendChild(made);
      return made;
    };
    put("line", { x1: 4, x2: w - 4, y1: sy(0), y2: sy(0), stroke: "#d4d8dd" });
    put("path", { d: points.map((p, i) => `${i ? "L" : "M"}${sx(p[0]).toFixed(1)} ${sy(p[1]).toFixed(1)}`).join(""), fill: "none", stroke: "#0072b2", "stroke-width": 1.5 });
    put("text", { x: 4, y: h - 2, "font-size": 12, fill: "#666" }, labels[0]);
    put("text", { x: w - 4, y: h - 2, "font-size": 12, fill: "#666", "text-anchor": "end" }, labels[1]);
    const dot = put("circle", { r: 3.5, fill: "#d55e00", stroke: "#fff" });
    parent.appendChild(svg);
    return (x, y) => { dot.setAttribute("cx", sx(x)); dot.setAttribute("cy", sy(y)); };
  }

  const angles = restAngles.slice(), speeds = joints.map(() => 0);
  const acting = joints.map((joint) => page.joints[joint.name]);
  const controls = joints.map(function (joint, j) {
    const stops = joint.stops, low = stops ? stops[0] : joint.rest - 45, high = stops ? stops[1] : joint.rest + 45;
    const row = make("div", { className: "joint3d" }, sliders);
    const label = make("label", { className: "slide" }, row), name = make("span", {}, label);
    const input = make("input", { type: "range", min: low, max: high, step: "any", value: joint.rest }, label);
    const words = make("p", { className: "readout" }, row), plots = make("div", { className: "small-plots" }, row);
    input.setAttribute("aria-label", `angle of the ${joint.name}, degrees`);
    const spring = (a) => -joint.rate * (joint.sign * (a - joint.zero) / DEG - joint.rotation);
    const line = []; for (let k = 0; k <= 20; k++) { const a = low + (high - low) * k / 20; line.push([a, joint.sign * spring(a)]); }
    const fastest = 8, curve = []; for (let k = -20; k <= 20; k++) curve.push([fastest * k / 20, -synthLeg.damperTorque(joint.damper, fastest * k / 20)]);
    const marks = [
      small(plots, `${joint.name}: spring torque against angle`, line, [`${low.toFixed(0)}°`, `spring, ${high.toFixed(0)}°`]),
      small(plots, `${joint.name}: damper torque against speed`, curve, [`−${fastest}`, `damper, ${fastest} rad/s`]),
    ];
    let last = 0;
    input.addEventListener("input", function (event) {
      stop();
      const now = performance.now(), value = parseFloat(input.value);
      const passed = (now - last) / 1000;
      speeds[j] = passed > 0 && passed < 0.25 ? joint.sign * (value - angles[j]) / DEG / passed : 0;
      last = now; angles[j] = value;
      clearTimeout(controls[j].still);
      controls[j].still = setTimeout(function () { speeds[j] = 0; update(); }, 250);
      update();
    });
    return { name, input, words, spring, marks, low, high, stops, still: 0 };
  });

  function tell(j) {
    const joint = joints[j], control = controls[j], angle = angles[j], chosen = acting[j].springs[0];
    const torque = joint.sign * control.spring(angle), resist = -joint.sign * synthLeg.damperTorque(joint.damper, speeds[j]);
    control.name.textContent = `${joint.name} ${shown(angle, 1)}°`;
    control.input.setAttribute("aria-valuetext", `${shown(angle, 1)} degrees`);
    let words = `spring ${shown(torque, 3)} N·m`;
    if (chosen.stress_per_torque) {
      words += `, ${shown(Math.abs(torque) * chosen.stress_per_torque, 0)} MPa`;
      if (chosen.allowed_mpa) words += ` of ${shown(chosen.allowed_mpa, 0)} allowed`;
    }
    words += ` · damper ${shown(resist, 3)} N·m`;
    let touches = false;
    if (control.stops) {
      const gap = Math.min(angle - control.stops[0], control.stops[1] - angle);
      touches = gap <= 0.05;
      words += touches ? " · touches the stop" : ` · ${shown(gap, 1)}° to the stop`;
    }
    control.words.textContent = words;
    control.words.classList.toggle("touches", touches);
    control.marks[0](angle, torque);
    control.marks[1](joint.sign * speeds[j], -synthLeg.damperTorque(joint.damper, joint.sign * speeds[j]));
  }

  // ---- drawing
  const box = new THREE.Box3();
  bodies.forEach((b) => box.union(b.mesh.geometry.boundingBox));
  const target = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3()).length();
  camera.position.copy(target).add(new THREE.Vector3(0.55, 0.3, 0.78).normalize().multiplyScalar(size * 1.95));
  const orbit = new THREE.OrbitControls(camera, canvas);
  orbit.target.copy(target); orbit.enableDamping = false; orbit.update();
  orbit.addEventListener("change", ask);
  let asked = false;
  function ask() { if (!asked) { asked = true; requestAnimationFrame(function () { asked = false; renderer.render(scene, camera); }); } }
  function fit() {
    const width = Math.max(200, panel.clientWidth), height = Math.max(220, Math.min(360, Math.round(width * 0.66)));
    renderer.setPixelRatio(Math.min(2, devicePixelRatio)); renderer.setSize(width, height);
    camera.aspect = width / height; camera.updateProjectionMatrix(); ask();
  }
  const M = new THREE.Matrix4(), T = new THREE.Matrix4();
  function update() {
    const now = frames(angles), apart = parseFloat(explode.value) * 0.3;
    bodies.forEach(function (b) {
      // A body's rest frame stands at the joint that it hangs from; the base's at the first.
      const at = Math.max(0, b.body - 1), turn = now.turns[b.body] - rest.turns[b.body];
      const [x, y] = now.at[at], [rx, ry] = rest.at[at];
      M.makeTranslation(x, y, 0).multiply(T.makeRotationZ(turn)).multiply(new THREE.Matrix4().makeTranslation(-rx, -ry, 0));
      if (apart) {
        const down = rest.turns[b.joint + (b.part.moves_with === "lower" ? 1 : 0)], side = b.part.moves_with === "upper" ? 0.1 : b.part.moves_with === "lower" ? -0.1 : 0;
        M.multiply(T.makeTranslation(-Math.sin(down) * side * apart * 2, Math.cos(down) * side * apart * 2, b.centre.z * apart * 8));
      }
      b.mesh.matrix.copy(M);
      if (b.twist) b.twist(joints[b.joint].sign * (angles[b.joint] - joints[b.joint].rest) / DEG);
    });
    joints.forEach(function (_, j) { controls[j].input.value = angles[j]; tell(j); });
    ask();
  }
  renderer.localClippingEnabled = true;
  section.addEventListener("input", function () {
    const share = parseFloat(section.value);
    cut.constant = share === 0 ? 1e3 : box.max.z - share * (box.max.z - box.min.z);
    ask();
  });
  explode.addEventListener("input", update);
  back.addEventListener("click", function () { stop(); restAngles.forEach((a, j) => { angles[j] = a; speeds[j] = 0; }); update(); });

  // ---- parts: pick, hide
  let picked = null;
  function pick(b) {
    if (picked) picked.mesh.material.emissive.setRGB(0, 0, 0);
    picked = b;
    if (!b) return;
    b.mesh.material.emissive.setRGB(0.25, 0.25, 0.05);
    const part = b.part, words = [part.name.replace(/_/g, " ")];
    if (part.material) words.push(part.material);
    if (part.mass) words.push(part.mass);
    if (part.files.length) words.push(part.files.join(", "));
    if (part.bill) words.push(`bill: ${part.bill}`);
    said.textContent = words.join(" · ");
    ask();
  }
  let down = [0, 0];
  canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
  canvas.addEventListener("click", function (event) {
    if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
    const rect = canvas.getBoundingClientRect(), caster = new THREE.Raycaster();
    scene.updateMatrixWorld(true);
    caster.setFromCamera(new THREE.Vector2((event.clientX - rect.left) / rect.width * 2 - 1, 1 - (event.clientY - rect.top) / rect.height * 2), camera);
    const hit = caster.intersectObjects(bodies.filter((b) => b.mesh.visible).map((b) => b.mesh)).find((h) => cut.distanceToPoint(h.point) >= 0);
    pick(hit ? bodies.find((b) => b.mesh === hit.object) : null);
  });
  canvas.addEventListener("keydown", function (event) {
    const turn = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    const away = camera.position.clone().sub(orbit.target);
    if (turn) {
      away.applyMatrix4(T.makeRotationY(turn[0]));
      const length = away.length(), polar = Math.min(3.1, Math.max(0.04, Math.acos(away.y / length) + turn[1])), around = Math.atan2(away.x, away.z);
      away.set(length * Math.sin(polar) * Math.sin(around), length * Math.cos(polar), length * Math.sin(polar) * Math.cos(around));
    } else if (event.key === "+" || event.key === "-") away.multiplyScalar(event.key === "+" ? 0.9 : 1.1);
    else return;
    event.preventDefault();
    camera.position.copy(orbit.target).add(away); orbit.update(); ask();
  });
  bodies.forEach(function (b) {
    const label = make("label", {}, boxes), tick = make("input", { type: "checkbox", checked: true }, label);
    const name = make("button", { type: "button", textContent: b.part.name.replace(/_/g, " "), title: "Tell what this part is" }, boxes);
    tick.setAttribute("aria-label", `show ${b.part.name.replace(/_/g, " ")}`);
    tick.addEventListener("change", function () { b.mesh.visible = tick.checked; ask(); });
    name.addEventListener("click", () => pick(b));
  });

  // ---- responses of the page's plots
  const responses = new Map();
  for (const plot of window.synthPlots ? synthPlots.of(document) : []) {
    if (!plot.data.curves.some((curve) => curve.name === "built") || !joints.some((joint) => joint.name === plot.data.joint)) continue;
    if (!responses.has(plot.group)) responses.set(plot.group, {});
    responses.get(plot.group)[plot.data.joint] = plot.data;
  }
  for (const [name, found] of responses) if (joints.some((joint) => !found[joint.name])) responses.delete(name);
  for (const name of responses.keys()) make("option", { value: name, textContent: name }, trials);
  for (const [value, words] of [["built", "built"], ["wanted", "wanted"], ["animal", "recorded"]]) make("option", { value, textContent: words }, kinds);
  if (!responses.size) { play.hidden = true; trialLabel.hidden = true; kindLabel.hidden = true; }

  function pose(name, time) {
    const found = responses.get(name);
    if (!found) return false;
    joints.forEach(function (joint, j) {
      const data = found[joint.name], values = data.curves.find((curve) => curve.name === kinds.value).values, times = data.time;
      let k = 1;
      while (k < times.length - 1 && times[k] < time) k++;
      const share = Math.min(1, Math.max(0, (time - times[k - 1]) / (times[k] - times[k - 1])));
      const a = values[k - 1], b = values[k];
      if (a === null || b === null) return;
      angles[j] = a + share * (b - a);
      speeds[j] = joint.sign * (b - a) / DEG / (times[k] - times[k - 1]);
    });
    update();
    return true;
  }
  let playing = null;
  function stop() { if (playing !== null) { cancelAnimationFrame(playing); playing = null; play.textContent = "▶ Play"; } }
  play.addEventListener("click", function () {
    if (playing !== null) { stop(); return; }
    const name = trials.value, times = responses.get(name)[joints[0].name].time, start = performance.now();
    play.textContent = "■ Stop";
    (function step() {
      const time = times[0] + (performance.now() - start) / 1000;
      const at = Math.min(time, times[times.length - 1]);
      pose(name, at);
      document.dispatchEvent(new CustomEvent("synth:time", { detail: { trial: name, time: at, from: "leg" } }));
      if (time > times[times.length - 1]) { playing = null; play.textContent = "▶ Play"; speeds.fill(0); update(); return; }
      playing = requestAnimationFrame(step);
    })();
  });
  const shownTime = function () { if (responses.size) { stop(); pose(trials.value, responses.get(trials.value)[joints[0].name].time[0]); } };
  trials.addEventListener("change", shownTime);
  kinds.addEventListener("change", shownTime);
  document.addEventListener("synth:time", function (event) {
    if (event.detail.from !== "plot" || !responses.has(event.detail.trial)) return;
    stop(); trials.value = event.detail.trial;
    pose(event.detail.trial, event.detail.time);
  });

  addEventListener("resize", fit);
  fit(); update();
  home.classList.add("turning");
}, 0));
