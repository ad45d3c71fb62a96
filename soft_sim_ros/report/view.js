// Plays a run in three dimensions. The library and the numbers are inside the page, packed.
(async () => {
  "use strict";
  const root = document.getElementById("view");
  const say = (text) => { root.querySelector("p").textContent = text; };
  const unpack = async (id) => {
    const text = document.getElementById(id).textContent;
    const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  };

  let THREE, meta, numbers, renderer;
  try {
    meta = JSON.parse(document.getElementById("view-meta").textContent);
    numbers = new Int16Array(await unpack("view-data"));
    const code = new Blob([await unpack("view-library")], { type: "text/javascript" });
    const address = URL.createObjectURL(code);
    THREE = await import(address);
    URL.revokeObjectURL(address);
    renderer = new THREE.WebGLRenderer({ antialias: true });
  } catch (error) {
    say("This browser cannot show the run in three dimensions (" + error.message + ").");
    return;
  }
  root.querySelector("p").remove();

  // ---- the run: poses at a moment between two recorded ones
  const { frames, poses, times, low, step, shares, tubes } = meta;
  const place = new Float32Array(3 * poses), turn = new Float32Array(9 * poses);
  const effort = new Float32Array(shares);
  const width = 7 * poses + shares;
  const pose = (t) => {
    let i = 0, j = frames - 1;
    while (j - i > 1) { const k = (i + j) >> 1; if (times[k] <= t) i = k; else j = k; }
    const span = times[j] - times[i];
    const f = span > 0 ? Math.min(Math.max((t - times[i]) / span, 0), 1) : 0;
    const a = i * width, b = j * width;
    const mix = (n) => numbers[a + n] + f * (numbers[b + n] - numbers[a + n]);
    for (let p = 0; p < poses; p++) {
      for (let c = 0; c < 3; c++) place[3 * p + c] = low[c] + step * (mix(7 * p + c) + 32767);
      let q = [0, 0, 0, 0], same = 0;
      for (let c = 0; c < 4; c++) same += numbers[a + 7 * p + 3 + c] * numbers[b + 7 * p + 3 + c];
      for (let c = 0; c < 4; c++) {
        const to = (same < 0 ? -1 : 1) * numbers[b + 7 * p + 3 + c];
        q[c] = numbers[a + 7 * p + 3 + c] * (1 - f) + to * f;
      }
      const size = Math.hypot(...q) || 1, [x, y, z, w] = q.map((v) => v / size);
      turn.set([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], 9 * p);
    }
    for (let e = 0; e < shares; e++) effort[e] = mix(7 * poses + e) / 32767;
  };

  // ---- what is seen
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xf7f9fb);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8a93a0, 2.2));
  const sun = new THREE.DirectionalLight(0xffffff, 1.6);
  sun.position.set(1, -2, 3);
  scene.add(sun);
  const middle = new THREE.Vector3(...meta.middle), reach = meta.reach;
  const cell = Math.pow(10, Math.floor(Math.log10(reach)));
  const cells = 2 * Math.ceil((1.5 * reach) / cell);
  const grid = new THREE.GridHelper(cells * cell, cells, 0x9aa5b1, 0xd9dee4);
  grid.rotation.x = Math.PI / 2;
  grid.position.set(Math.round(middle.x / cell) * cell, Math.round(middle.y / cell) * cell,
    meta.floor);
  scene.add(grid);
  const axes = new THREE.AxesHelper(0.15 * reach);
  scene.add(axes);
  for (const points of meta.trails) {
    const trail = new THREE.BufferGeometry();
    trail.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    scene.add(new THREE.Line(trail, new THREE.LineBasicMaterial({ color: 0x66717d })));
  }

  const ramp = [[0, 0.45, 0.7], [0.94, 0.8, 0.25], [0.84, 0.37, 0]];
  const shade = (colour, share) => {
    const s = Math.min(Math.abs(share), 1) * 2, i = s < 1 ? 0 : 1;
    const [r, g, b] = ramp[i].map((v, c) => v + (ramp[i + 1][c] - v) * (s - i));
    colour.setRGB(r, g, b, THREE.SRGBColorSpace);
  };
  const drawn = tubes.map(({ at, rings, effort: index, clear }) => {
    const sides = rings[0].length / 2, count = at.length, corners = [];
    for (let i = 0; i < count - 1; i++) {
      for (let j = 0; j < sides; j++) {
        const a = i * sides + j, b = i * sides + ((j + 1) % sides);
        corners.push(a, b, b + sides, a, b + sides, a + sides);
      }
    }
    const end = (count - 1) * sides;
    for (let j = 1; j < sides - 1; j++) corners.push(0, j + 1, j, end, end + j, end + j + 1);
    const shape = new THREE.BufferGeometry();
    const points = new THREE.BufferAttribute(new Float32Array(3 * sides * count), 3);
    shape.setAttribute("position", points);
    shape.setIndex(corners);
    const look = new THREE.MeshStandardMaterial({ color: 0xd8c3a0, roughness: 0.6 });
    if (clear) Object.assign(look, { transparent: true, opacity: 0.45, depthWrite: false });
    const mesh = new THREE.Mesh(shape, look);
    mesh.frustumCulled = false;
    scene.add(mesh);
    return () => {
      const xyz = points.array;
      for (let i = 0, n = 0; i < count; i++) {
        const p = 3 * at[i], m = 9 * at[i], ring = rings[i];
        for (let j = 0; j < sides; j++) {
          const y = ring[2 * j], z = ring[2 * j + 1];
          for (let c = 0; c < 3; c++) {
            xyz[n++] = place[p + c] + turn[m + 3 * c + 1] * y + turn[m + 3 * c + 2] * z;
          }
        }
      }
      points.needsUpdate = true;
      shape.computeVertexNormals();
      if (index >= 0) shade(look.color, effort[index]);
    };
  });

  // ---- what stands around, and forces of contacts
  for (const { kind, size, place: at, turn: q, opacity } of meta.solids) {
    const shape = kind === "box" ? new THREE.BoxGeometry(1, 1, 1)
      : kind === "cylinder" ? new THREE.CylinderGeometry(0.5, 0.5, 1, 40)
        : new THREE.SphereGeometry(0.5, 40, 24);
    if (kind === "cylinder") shape.rotateX(Math.PI / 2); // along z, as everywhere
    const mesh = new THREE.Mesh(shape, new THREE.MeshStandardMaterial({ color: 0x8c8780,
      roughness: 0.9, transparent: true, opacity, depthWrite: false }));
    mesh.scale.set(...size);
    mesh.position.set(...at);
    mesh.quaternion.set(...q);
    mesh.renderOrder = -1;
    scene.add(mesh);
  }
  const most = Math.max(0, ...meta.pushes.map((found) => found.length / 7));
  const arrows = Array.from({ length: most }, () => {
    const arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), middle, 1, 0xffffff);
    scene.add(arrow);
    return arrow;
  });
  const push = (t) => {
    let i = 0, j = frames - 1;
    while (i < j) { const k = (i + j + 1) >> 1; if (times[k] <= t) i = k; else j = k - 1; }
    const found = meta.pushes[i] || [];
    arrows.forEach((arrow, k) => {
      const [x, y, z, fx, fy, fz, sticks] = found.slice(7 * k, 7 * k + 7);
      const size = Math.hypot(fx, fy, fz);
      arrow.visible = size > 0;
      if (!arrow.visible) return;
      const long = (0.4 * reach * size) / (size + 0.3);
      arrow.position.set(x, y, z);
      arrow.setDirection(new THREE.Vector3(fx / size, fy / size, fz / size));
      arrow.setLength(long, 0.3 * long, 0.15 * long);
      arrow.setColor(sticks ? 0x009e73 : 0xd55e00);
    });
  };

  // ---- the eye: turns about a point, z stays up
  const eye = new THREE.OrthographicCamera(-1, 1, 1, -1, -100 * reach, 100 * reach);
  eye.up.set(0, 0, 1);
  const look = { azimuth: -0.95, height: 0.35, zoom: 1, at: middle.clone() };
  let changed = true;
  const aim = (azimuth, height) => {
    Object.assign(look, { azimuth, height, zoom: 1 });
    look.at.copy(middle);
    changed = true;
  };
  root.appendChild(renderer.domElement);
  const canvas = renderer.domElement;
  canvas.setAttribute("aria-label", "The arm in three dimensions; drag turns, wheel zooms");
  let looked = 0;
  const resize = () => {
    const w = Math.max(root.clientWidth, 1);
    if (w === looked) return;
    looked = w;
    const h = Math.round(Math.min(0.62 * w + 60, 560));
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    renderer.setSize(w, h);
    const tall = 1.15 * reach, wide = (tall * w) / h;
    const more = wide < tall ? tall / wide : 1;
    Object.assign(eye, { left: -wide * more, right: wide * more, top: tall * more,
      bottom: -tall * more });
    changed = true;
  };
  new ResizeObserver(() => requestAnimationFrame(resize)).observe(root);
  const fingers = new Map();
  canvas.addEventListener("pointerdown", (e) => {
    canvas.setPointerCapture(e.pointerId);
    fingers.set(e.pointerId, [e.clientX, e.clientY]);
  });
  const lift = (e) => fingers.delete(e.pointerId);
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("pointermove", (e) => {
    const was = fingers.get(e.pointerId);
    if (!was) return;
    const dx = e.clientX - was[0], dy = e.clientY - was[1];
    if (fingers.size > 1) {
      const other = [...fingers].find(([id]) => id !== e.pointerId)[1];
      const far = (x, y) => Math.hypot(x - other[0], y - other[1]) || 1;
      look.zoom *= far(e.clientX, e.clientY) / far(...was);
    } else if (e.shiftKey || e.buttons === 2) {
      const scale = (eye.top - eye.bottom) / look.zoom / canvas.clientHeight;
      const m = eye.matrixWorld.elements;
      look.at.addScaledVector(new THREE.Vector3(m[0], m[1], m[2]), -dx * scale);
      look.at.addScaledVector(new THREE.Vector3(m[4], m[5], m[6]), dy * scale);
    } else {
      look.azimuth -= 0.008 * dx;
      look.height = Math.min(Math.max(look.height + 0.008 * dy, -Math.PI / 2), Math.PI / 2);
    }
    fingers.set(e.pointerId, [e.clientX, e.clientY]);
    changed = true;
  });
  canvas.addEventListener("wheel", (e) => {
    e.preventDefault();
    look.zoom = Math.min(Math.max(look.zoom * Math.exp(-0.001 * e.deltaY), 0.1), 50);
    changed = true;
  }, { passive: false });
  canvas.addEventListener("contextmenu", (e) => e.preventDefault());

  // ---- controls
  const make = (kind, inside, more) => Object.assign(document.createElement(kind), inside, more);
  const bar = make("div", { className: "bar" });
  const begin = times[0], end = times[frames - 1];
  let now = begin, speed = 1, playing = false;
  const play = make("button", { type: "button", textContent: "Play" });
  const scrub = make("input", { type: "range", min: 0, max: 1000, value: 0 });
  scrub.setAttribute("aria-label", "time");
  const clock = make("output", {});
  const pace = make("select", { title: "speed" });
  for (const x of [0.1, 0.25, 0.5, 1, 2, 5, 10]) {
    pace.append(make("option", { value: x, textContent: x + " ×", selected: x === 1 }));
  }
  pace.addEventListener("change", () => { speed = Number(pace.value); });
  const start = (on) => {
    if (on && now >= end) now = begin;
    playing = on;
    play.textContent = on ? "Pause" : "Play";
    changed = true;
  };
  play.addEventListener("click", () => start(!playing));
  scrub.addEventListener("input", () => {
    start(false);
    now = begin + ((end - begin) * scrub.value) / 1000;
  });
  bar.append(play, scrub, clock, pace);
  const quarter = Math.PI / 2;
  for (const [name, azimuth, height] of [["Front", -quarter, 0], ["Side", 0, 0],
    ["Top", -quarter, quarter], ["3-D", -0.95, 0.35]]) {
    const button = make("button", { type: "button", textContent: name });
    button.addEventListener("click", () => aim(azimuth, height));
    bar.append(button);
  }
  root.append(bar);
  root.append(make("p", { className: "hint",
    textContent: "Drag turns, shift-drag moves, the wheel zooms. Axes x red, y green, z blue; " +
      "one cell of the grid is " + Number(cell.toPrecision(3)) + " m. " + meta.legend }));

  let before = 0;
  const frame = (stamp) => {
    const passed = Math.min((stamp - before) / 1000, 0.1);
    before = stamp;
    if (playing) {
      now = Math.min(now + passed * speed, end);
      changed = true;
      if (now >= end) start(false);
    }
    if (changed) {
      changed = false;
      pose(now);
      for (const draw of drawn) draw();
      push(now);
      axes.position.fromArray(place, 0);
      const flat = Math.cos(look.height);
      eye.zoom = look.zoom;
      const over = Math.sign(look.height), a = look.azimuth;
      eye.up.set(...(flat > 1e-6 ? [0, 0, 1] : [-over * Math.cos(a), -over * Math.sin(a), 0]));
      eye.position.copy(look.at).add(new THREE.Vector3(
        Math.cos(look.azimuth) * flat, Math.sin(look.azimuth) * flat, Math.sin(look.height)));
      eye.lookAt(look.at);
      eye.updateProjectionMatrix();
      renderer.render(scene, eye);
      scrub.value = end > begin ? (1000 * (now - begin)) / (end - begin) : 0;
      clock.value = now.toFixed(2) + " s";
      root.dataset.time = now.toFixed(3);
    }
    requestAnimationFrame(frame);
  };
  resize();
  start(!window.matchMedia("(prefers-reduced-motion: reduce)").matches && end > begin);
  requestAnimationFrame((stamp) => { before = stamp; frame(stamp); });
  root.dataset.ready = "yes";
})();
