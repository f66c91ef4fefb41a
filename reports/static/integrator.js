// The leg's motion in the page: a planar chain with springs and dampers, Dormand-Prince 5(4) with step control.
// In absolute rotations phi the kinetic energy is 1/2 sum (A_ij cos(phi_i - phi_j) + B_ij sin(phi_i - phi_j)) dphi_i
// dphi_j and the potential energy sum (H_i sin(phi_i) - G_i cos(phi_i)) (synth.swing.mechanics); joint torques act between a link and its parent. Rotations in rad, SI.
"use strict";
window.synthLeg = (function () {
  function damperTorque(damper, speed) {
    if (!damper.speed) return damper.rate * speed;
    let sum = 0;
    for (let i = 0; i < damper.speed.length; i++) {
      const limit = damper.speed[i];
      sum += damper.slope[i] * Math.max(-limit, Math.min(limit, speed));
    }
    return sum;
  }

  // Effects of the built leg, as in synth/swing/effects: torque on q of what resists beside spring and damper. A
  // friction's bristle z bends with the motion and holds within -1..1; `bends` takes its rate of change.
  // The engine turns a sliding bristle over at once where its joint turns back (synth.swing.turning_events); here it
  // bends over, with so little give that half a swing is late by twice LEAST_PRESLIDING, 0.002 deg.
  const LEAST_PRESLIDING = 2e-5, BRISTLE_DAMPING = 0.0005;  // rad, s
  const NOTHING = { friction: [], drag: [], hardening: [] };
  function effects(own, deflection, rate, speed, z, first, bends) {
    let sum = 0;
    own.friction.forEach(function (f, k) {
      const bend = z[first + k], net = speed - (f.creep || 0) * bend;
      const least = f.creep ? 2e-4 : LEAST_PRESLIDING;  // less makes a creeping joint stiff to integrate
      const change = Math.abs(bend) >= 1 && net * bend > 0 ? 0 : net / Math.max(f.presliding, least);
      const held = Math.max(-1, Math.min(1, Math.abs(bend) < 1 ? bend + BRISTLE_DAMPING * change : bend));
      const level = f.torque * (f.fall ? 1 - f.fall + f.fall * Math.pow(1 + Math.pow(speed / f.speed, 2) / 16, -16) : 1);
      sum -= level * held * (1.5 - 0.5 * held * held);
      bends[first + k] = change;
    });
    for (const d of own.drag) sum -= d.coefficient * d.speed * speed * Math.pow((Math.abs(speed) + 1e-9) / d.speed, d.exponent - 1);
    for (const h of own.hardening) {
      const extra = h.stiffening * Math.pow((Math.max(Math.abs(deflection) - h.onset, 0) + 1e-9) / h.reach, h.exponent);
      sum += rate * deflection * (1 - 1 / Math.sqrt(1 + Math.pow(h.softening * deflection, 2))) - (deflection > 0 ? extra : -extra);
    }
    return sum;
  }

  // Accelerations of the joints; locked ones keep still. `acting[j]` = {rate, rotation, damper, effects}; bristles `z`
  // stand joint by joint, their rates of change go to `bends`.
  function accelerations(release, acting, q, v, out, z, bends) {
    const n = q.length, phi = new Float64Array(n), omega = new Float64Array(n);
    let angle = release.tilt, turning = 0;
    for (let i = 0; i < n; i++) { angle += q[i]; turning += v[i]; phi[i] = angle; omega[i] = turning; }
    const force = new Float64Array(n);  // in phi, then summed over the links outboard of each joint
    for (let i = 0; i < n; i++) {
      let sum = -release.gravity[i] * Math.sin(phi[i]) - release.gravity_across[i] * Math.cos(phi[i]);
      for (let j = 0; j < n; j++) {
        const along = release.inertia[i][j], across = release.inertia_across[i][j], between = phi[i] - phi[j];
        sum -= (along * Math.sin(between) - across * Math.cos(between)) * omega[j] * omega[j];
      }
      force[i] = sum;
    }
    for (let i = n - 2; i >= 0; i--) force[i] += force[i + 1];
    const free = [];
    for (let i = 0, at = 0; i < n; i++) {
      const a = acting[i], own = a.effects || NOTHING;
      force[i] -= a.rate * (q[i] - a.rotation) + damperTorque(a.damper, v[i]);
      force[i] += effects(own, q[i] - a.rotation, a.rate, v[i], z, at, bends);
      at += own.friction.length;
      out[i] = 0;
      if (!release.locked.includes(i)) free.push(i);
    }
    // Mass matrix in joint coordinates: sums of A_kl cos(phi_k - phi_l) over links outboard of both joints.
    const whole = [];
    for (let i = 0; i <= n; i++) whole.push(new Float64Array(n + 1));
    for (let i = n - 1; i >= 0; i--) for (let j = n - 1; j >= 0; j--) {
      const between = phi[i] - phi[j];
      const own = release.inertia[i][j] * Math.cos(between) + release.inertia_across[i][j] * Math.sin(between);
      whole[i][j] = own + whole[i + 1][j] + whole[i][j + 1] - whole[i + 1][j + 1];
    }
    for (const i of free) whole[i][i] += (acting[i].effects || NOTHING).armature || 0;
    const m = free.length, a = [];
    for (let r = 0; r < m; r++) { a.push(new Float64Array(m + 1)); for (let c = 0; c < m; c++) a[r][c] = whole[free[r]][free[c]]; a[r][m] = force[free[r]]; }
    for (let c = 0; c < m; c++) for (let r = c + 1; r < m; r++) {  // symmetric and positive: no pivoting
      const share = a[r][c] / a[c][c];
      for (let k = c; k <= m; k++) a[r][k] -= share * a[c][k];
    }
    for (let r = m - 1; r >= 0; r--) {
      let sum = a[r][m];
      for (let c = r + 1; c < m; c++) sum -= a[r][c] * out[free[c]];
      out[free[r]] = sum / a[r][r];
    }
    return out;
  }

  const C = [0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1];
  const A = [[], [1 / 5], [3 / 40, 9 / 40], [44 / 45, -56 / 15, 32 / 9], [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
    [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656], [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84]];
  const E = [71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40];  // 5th less 4th order
  const TOLERANCE = 1e-5, MOST_STEPS = 20000;

  // Rotations (one array a joint) at the release's times; null where the motion cannot be followed.
  function motion(release, acting) {
    const n = release.rotation.length, times = release.time, stages = [];
    const m = acting.reduce((sum, a) => sum + (a.effects || NOTHING).friction.length, 0), all = 2 * n + m;
    const y = new Float64Array(all);  // rotations, their rates, bristles (straight at the release)
    for (let i = 0; i < n; i++) { y[i] = release.rotation[i]; y[n + i] = release.locked.includes(i) ? 0 : release.rate[i]; }
    for (let s = 0; s < 7; s++) stages.push(new Float64Array(all));
    const acc = new Float64Array(n), trial = new Float64Array(all);
    const slope = function (state, into) {
      accelerations(release, acting, state.subarray(0, n), state.subarray(n, 2 * n), acc, state.subarray(2 * n), into.subarray(2 * n));
      for (let i = 0; i < n; i++) { into[i] = state[n + i]; into[n + i] = acc[i]; }
    };
    const found = [];
    for (let i = 0; i < n; i++) found.push(new Float64Array(times.length));
    for (let i = 0; i < n; i++) found[i][0] = y[i];
    let t = times[0], h = 1e-3, steps = 0;
    slope(y, stages[0]);
    for (let i = 0, at = 2 * n; i < n; i++) for (const f of (acting[i].effects || NOTHING).friction) {  // as if it had slid
      if (f.presliding < 2e-4) y[at] = Math.sign(y[n + i] || acc[i]);
      at++;
    }
    if (m) slope(y, stages[0]);
    for (let k = 1; k < times.length; k++) {
      while (t < times[k] - 1e-12) {
        if (++steps > MOST_STEPS) return null;
        const last = t + h >= times[k], step = last ? times[k] - t : h;
        for (let s = 1; s < 7; s++) {
          for (let i = 0; i < all; i++) { let sum = 0; for (let p = 0; p < s; p++) sum += A[s][p] * stages[p][i]; trial[i] = y[i] + step * sum; }
          slope(trial, stages[s]);
        }
        let error = 0;
        for (let i = 0; i < 2 * n; i++) {
          let sum = 0;
          for (let s = 0; s < 7; s++) sum += E[s] * stages[s][i];
          const scale = i < n ? TOLERANCE : TOLERANCE * 30;  // a rate of 30 rad/s for a radian
          error = Math.max(error, Math.abs(step * sum) / (scale * (1 + (i < n ? 0 : Math.abs(y[i]) / 30))));
        }
        if (!isFinite(error)) return null;
        if (error <= 1) {
          y.set(trial); t += step;
          const first = stages[0]; stages[0] = stages[6]; stages[6] = first;  // the last stage is the next first
          for (let i = 2 * n; i < all; i++) if (Math.abs(y[i]) > 1) y[i] = Math.sign(y[i]);  // a step may bend it too far
          if (m) slope(y, stages[0]);
        }
        const factor = Math.min(4, Math.max(0.2, 0.9 * Math.pow(Math.max(error, 1e-10), -0.2)));
        if (error > 1 || !last || factor < 1) h = step * factor;
        if (h < 1e-9) return null;
      }
      for (let i = 0; i < n; i++) found[i][k] = y[i];
    }
    return found;
  }

  const DEG = 180 / Math.PI;
  function measured(joint, rotation) { return joint.zero + joint.sign * rotation * DEG; }

  // Root mean square of built less wanted, degrees: of each joint, and of all.
  function errors(joints, replay, motions) {
    const n = joints.length, square = new Float64Array(n), count = new Float64Array(n);
    replay.releases.forEach(function (release, r) {
      for (let j = 0; j < n; j++) {
        if (release.locked.includes(j)) continue;
        for (let k = 0; k < release.time.length; k++) {
          const off = motions[r] === null ? 180 : measured(joints[j], motions[r][j][k]) - release.wanted[j][k];
          square[j] += off * off; count[j]++;
        }
      }
    });
    const each = Array.from(square, (s, j) => Math.sqrt(s / Math.max(1, count[j])));
    return { joints: each, all: Math.sqrt(each.reduce((sum, e) => sum + e * e, 0) / n) };
  }
  return { motion, errors, damperTorque, measured };
})();
