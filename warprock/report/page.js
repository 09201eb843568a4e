// Sortable tables and the player of lanes. No library, no network.
(function () {
  "use strict";
  const SVG = "http://www.w3.org/2000/svg";
  const COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];

  function make(name, attributes, parent, text) {
    const element = document.createElementNS(SVG, name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    if (text !== undefined) element.textContent = text;
    if (parent) parent.appendChild(element);
    return element;
  }

  // ---- tables --------------------------------------------------------------------------------

  function sortKey(text) {
    const number = Number(text.replace(/,/g, "").replace(/[%*]$/, ""));
    return text !== "" && !Number.isNaN(number) ? number : text;
  }

  function compare(a, b, down) {
    const missing = (value) => value === "-" || value === "";
    if (missing(a) || missing(b)) return missing(a) - missing(b);
    const numbers = typeof a === "number" && typeof b === "number";
    const order = numbers ? a - b : String(a).localeCompare(String(b), undefined, { numeric: true });
    return down ? -order : order;
  }

  function setUpTable(figure) {
    const table = figure.querySelector("table");
    const body = table.tBodies[0];
    const most = Number(figure.dataset.rows);
    const more = figure.querySelector(".more");
    const filter = figure.querySelector(".filter input");
    let all = false;

    function show() {
      const wanted = filter ? filter.value.trim().toLowerCase() : "";
      let shown = 0;
      for (const row of body.rows) {
        const hit = wanted === "" || row.textContent.toLowerCase().includes(wanted);
        row.hidden = !hit || (!all && shown >= most);
        if (hit) shown += 1;
      }
      if (more) {
        more.hidden = shown <= most;
        more.textContent = all ? "Show fewer rows" : "Show all " + shown + " rows";
      }
    }

    table.querySelectorAll("thead button").forEach(function (button) {
      button.addEventListener("click", function () {
        const head = button.closest("th");
        const down = head.getAttribute("aria-sort") === "ascending";
        const column = head.cellIndex;
        table.querySelectorAll("th[aria-sort]").forEach((other) => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", down ? "descending" : "ascending");
        Array.from(body.rows)
          .map((row) => [sortKey(row.cells[column].textContent.trim()), row])
          .sort((a, b) => compare(a[0], b[0], down))
          .forEach((pair) => body.appendChild(pair[1]));
        show();
      });
    });
    if (filter) filter.addEventListener("input", show);
    if (more) {
      more.addEventListener("click", function () {
        all = !all;
        show();
      });
    }
    show();
  }

  // ---- player --------------------------------------------------------------------------------

  // A round step so that about `count` of them span a length.
  function roundStep(length, count) {
    const raw = length / count;
    const size = Math.pow(10, Math.floor(Math.log10(raw)));
    return [1, 2, 5, 10].map((part) => part * size).find((step) => step >= raw * 0.999);
  }

  function written(value, step) {
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    return value.toFixed(Math.min(digits, 8));
  }

  // Attitude (x, y, z, w) applied to a vector.
  function turned(q, v) {
    const [x, y, z, w] = q;
    const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
    return [
      v[0] + w * t[0] + y * t[2] - z * t[1],
      v[1] + w * t[1] + z * t[0] - x * t[2],
      v[2] + w * t[2] + x * t[1] - y * t[0],
    ];
  }

  // Those of some points of the picture that the others lie between, going round.
  function hull(points) {
    const chain = (found, p) => {
      const [a, b] = found.slice(-2);
      const inside = b && (b[0] - a[0]) * (p[1] - a[1]) <= (b[1] - a[1]) * (p[0] - a[0]);
      return inside ? chain(found.slice(0, -1), p) : found.concat([p]);
    };
    const sorted = points.slice().sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    return sorted.reduce(chain, []).slice(0, -1).concat(sorted.reverse().reduce(chain, []).slice(0, -1));
  }

  const FACES = [
    [0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3],
  ];

  function Player(root) {
    this.root = root;
    this.lanes = JSON.parse(document.getElementById(root.dataset.scenes).textContent).lanes;
    const find = (name) => root.querySelector(name);
    // A quantity that never changes is one number.
    const full = (values, n) => (values.length === 1 && n > 1 ? Array(n).fill(values[0]) : values);
    this.lanes.forEach((lane) => {
      lane.acc = full(lane.acc, lane.n);
      lane.blocks.forEach((block) => (block.r = full(block.r, lane.n)));
    });
    this.scene = find(".scene");
    this.plot = find(".plot");
    this.slider = find(".time");
    this.button = find(".play");
    this.choice = find(".lane");
    this.speed = find(".speed");
    this.follow = find(".follow");
    this.turn = find(".turn");
    this.now = find(".now");
    this.about = find(".about");
    this.playing = false;
    this.touched = false;
    this.lanes.forEach((lane, at) => this.choice.add(new Option(lane.name, String(at))));
    this.choice.addEventListener("change", () => this.load(Number(this.choice.value)));
    this.button.addEventListener("click", () => this.toggle());
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.follow.addEventListener("change", () => this.layout());
    this.turn.addEventListener("input", () => this.draw());
    root.addEventListener("keydown", (event) => this.key(event));
    this.plot.addEventListener("pointerdown", (event) => this.point(event, true));
    this.plot.addEventListener("pointermove", (event) => this.point(event, event.buttons === 1));
    let width = 0;
    new ResizeObserver(() => {
      // Height follows from the width, so that only a new width is news.
      if (Math.abs(root.clientWidth - width) > 1 && root.clientWidth > 0) {
        width = root.clientWidth;
        this.layout();
      }
    }).observe(root);
    this.load(0);
  }

  Player.prototype.load = function (at) {
    this.pause();
    const lane = (this.lane = this.lanes[at]);
    this.choice.value = String(at);
    this.end = (lane.n - 1) * lane.dt;
    this.slider.max = String(this.end);
    this.slider.step = String(lane.dt);
    this.turn.closest("label").hidden = !lane.spatial;
    this.about.textContent = lane.about;
    let farthest = 0;
    ["x", "z"].forEach((axis) => {
      for (let i = 0; i < lane.n; i++) farthest = Math.max(farthest, Math.abs(this.value(lane.base[axis], i, lane.length)));
    });
    this.follow.closest("label").hidden = farthest === 0;
    // A base that drifts out of the picture takes the view with it.
    this.follow.checked = farthest > 1.5 * (lane.tall || lane.blocks.reduce((sum, block) => sum + block.h, 0));
    // The largest rotation is the picture that says most while nothing plays.
    let peak = 0;
    let where = 0;
    lane.blocks.forEach((block) => block.r.forEach((value, i) => {
      const ratio = Math.abs(value) / block.alpha[value < 0 ? 0 : 1];
      if (ratio > peak) [peak, where] = [ratio, i];
    }));
    this.touched = false;
    this.time = where * lane.dt;
    this.layout();
  };

  Player.prototype.value = function (values, i, unit) {
    return values && values.length ? values[Math.min(i, values.length - 1)] * unit : 0;
  };

  // A sampled value at the time shown, between its two samples.
  Player.prototype.at = function (values, unit) {
    const place = Math.min(this.time / this.lane.dt, this.lane.n - 1);
    const i = Math.floor(place);
    const low = this.value(values, i, unit);
    return low + (place - i) * (this.value(values, i + 1, unit) - low);
  };

  Player.prototype.toggle = function () {
    if (this.playing) return this.pause();
    if (!this.touched || this.time >= this.end - 1e-9) this.time = 0;
    this.touched = this.playing = true;
    this.button.textContent = "Pause";
    this.button.setAttribute("aria-pressed", "true");
    // A frame has the time at which it began, which may be before the key was pressed.
    let last = null;
    const step = (now) => {
      if (!this.playing) return;
      if (last !== null) this.time += ((now - last) / 1000) * Number(this.speed.value);
      last = now;
      if (this.time >= this.end) {
        this.time = this.end;
        this.pause();
      }
      this.draw();
      if (this.playing) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  };

  Player.prototype.pause = function () {
    this.playing = false;
    this.button.textContent = "Play";
    this.button.setAttribute("aria-pressed", "false");
  };

  Player.prototype.seek = function (time) {
    this.pause();
    this.touched = true;
    this.time = Math.min(Math.max(time, 0), this.end);
    this.draw();
  };

  Player.prototype.key = function (event) {
    const own = event.target;
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    if (event.key === " " && own.tagName !== "BUTTON" && own.type !== "checkbox") this.toggle();
    else if (own !== this.plot && own !== this.scene) return;
    else if (event.key === "ArrowRight") this.seek(this.time + this.end / 200);
    else if (event.key === "ArrowLeft") this.seek(this.time - this.end / 200);
    else if (event.key === "Home") this.seek(0);
    else if (event.key === "End") this.seek(this.end);
    else return;
    event.preventDefault();
  };

  Player.prototype.point = function (event, wanted) {
    if (!wanted) return;
    const box = this.plot.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * this.width;
    this.seek(((x - this.left) / (this.right - this.left)) * this.end);
  };

  // Corners of every block at the time shown: [x, y, z], y across the plane of rocking.
  Player.prototype.corners = function () {
    const lane = this.lane;
    return lane.blocks.map((block) => {
      const r = this.at(block.r, lane.angle);
      const centre = [this.at(block.x, lane.length), this.at(block.y, lane.length), this.at(block.z, lane.length)];
      let q = [0, Math.sin(r / 2), 0, Math.cos(r / 2)];
      if (block.q) {
        const parts = block.q.map((part) => this.at(part, lane.attitude));
        const size = Math.hypot(...parts) || 1;
        q = parts.map((part) => part / size);
      }
      const moved = (arm) => turned(q, arm).map((value, k) => value + centre[k]);
      if (block.p) return block.p.map(moved);
      const found = [];
      for (const a of [-0.5, 0.5])
        for (const b of [-0.5, 0.5])
          for (const c of [-0.5, 0.5]) found.push(moved([a * block.w, b * block.d, c * block.h]));
      return found;
    });
  };

  Player.prototype.base = function () {
    const lane = this.lane;
    return ["x", "y", "z"].map((axis) => this.at(lane.base[axis], lane.length));
  };

  // Where a point lies in the picture, before scale: to the right, up, and away from the reader.
  Player.prototype.seen = function (point) {
    if (!this.lane.spatial) return [point[0], point[2], point[1]];
    const turn = (Number(this.turn.value) * Math.PI) / 180;
    const across = point[0] * Math.cos(turn) + point[1] * Math.sin(turn);
    const away = point[1] * Math.cos(turn) - point[0] * Math.sin(turn);
    return [across, point[2] * 0.94 + away * 0.34, away * 0.94 - point[2] * 0.34];
  };

  Player.prototype.ground = function () {
    const lane = this.lane;
    return lane.ground ? ["x", "y", "z"].map((axis) => this.at(lane.ground[axis], lane.length)) : null;
  };

  // Points of a part of what holds the block at the time shown.
  Player.prototype.pointsOf = function (part) {
    const lane = this.lane;
    const base = this.base();
    return part.points.map(([number, x, z]) => {
      const mover = lane.movers[number];
      if (mover.on === "block") {
        const block = lane.blocks[0];
        const r = this.at(block.r, lane.angle);
        const arm = turned([0, Math.sin(r / 2), 0, Math.cos(r / 2)], [x, 0, z]);
        return [this.at(block.x, lane.length) + arm[0] + mover.shift, 0, this.at(block.z, lane.length) + arm[2]];
      }
      const along = mover.x ? this.at(mover.x, lane.length) : 0;
      const up = mover.z ? this.at(mover.z, lane.length) : 0;
      return [base[0] + along + x + mover.shift, 0, base[2] + up + z];
    });
  };

  // What a tie does at the time shown, in a word; nothing of other parts.
  Player.prototype.doing = function (part) {
    const sample = Math.floor(this.time / this.lane.dt + 1e-6);
    return (part.states || []).reduce((word, [from, state]) => (from <= sample ? state : word), "");
  };

  // Everything that stays the same while a lane plays.
  Player.prototype.layout = function () {
    const lane = this.lane;
    const width = Math.max(280, Math.round(this.root.clientWidth));
    const kept = this.time;
    const box = { x: [Infinity, -Infinity], y: [Infinity, -Infinity] };
    const reach = (point) => {
      const at = this.seen(point);
      box.x = [Math.min(box.x[0], at[0]), Math.max(box.x[1], at[0])];
      box.y = [Math.min(box.y[0], at[1]), Math.max(box.y[1], at[1])];
    };
    this.tall = lane.tall || lane.blocks.reduce((sum, block) => sum + block.h, 0);
    this.wide = Math.max(...lane.blocks.map((block) => Math.max(block.w, lane.spatial ? block.d : 0)));
    // What is fixed of an assembly is drawn as it is.
    this.plate = lane.assembly ? lane.plate || 0 : 0.5 * Math.max(2.2 * this.wide, 0.5 * this.tall);
    const span = lane.span || [0, 0];
    this.plates = [Math.min(-this.plate, span[0]), Math.max(this.plate, span[1])];
    this.thick = 0.07 * this.tall;
    // How far below the block the ground of a support begins.
    this.gap = 2.2 * this.thick;
    const turns = lane.spatial ? [-60, -30, 0, 30, 60] : [Number(this.turn.value)];
    const shown = this.turn.value;
    for (let i = 0; i <= 240; i++) {
      this.time = (this.end * i) / 240;
      const b = this.base();
      const off = this.follow.checked ? b : [0, 0, 0];
      const points = this.corners().flat();
      const ground = this.ground();
      for (const end of this.plates)
        for (const t of lane.spatial ? [-1, 1] : [0]) {
          points.push([b[0] + end, b[1] + t * this.plate, b[2] + (lane.floor || 0) - this.thick]);
          if (ground) points.push([ground[0] + end, ground[1] + t * this.plate, ground[2] - this.gap - this.thick]);
        }
      (lane.parts || []).forEach((part) => points.push(...this.pointsOf(part)));
      for (const angle of turns) {
        this.turn.value = String(angle);
        points.forEach((p) => reach(p.map((value, k) => value - off[k])));
      }
    }
    this.turn.value = shown;
    this.time = kept;
    const [w, h] = [box.x[1] - box.x[0], box.y[1] - box.y[0]];
    const height = Math.round(Math.min(420, Math.max(200, (width * h * 1.15) / w)));
    // The beam of a frame may reach below the clock.
    const above = lane.parts ? 28 : 10;
    this.scale = Math.min((width - 24) / w, (height - above - 34) / h);
    this.shift = [width / 2 - (this.scale * (box.x[0] + box.x[1])) / 2, above + this.scale * box.y[1]];
    this.size = [width, height];
    this.scene.setAttribute("viewBox", "0 0 " + width + " " + height);
    this.drawPlot(width);
    this.draw();
  };

  Player.prototype.place = function (point) {
    const at = this.seen(point);
    return [this.shift[0] + this.scale * at[0], this.shift[1] - this.scale * at[1], at[2]];
  };

  Player.prototype.draw = function () {
    const lane = this.lane;
    const svg = this.scene;
    const base = this.base();
    const off = this.follow.checked ? base : [0, 0, 0];
    const put = (point) => this.place(point.map((value, k) => value - off[k]));
    const polygon = (points, attributes) =>
      make("polygon", Object.assign({ points: points.map((p) => p[0].toFixed(1) + "," + p[1].toFixed(1)).join(" ") }, attributes), svg);
    // Blocks stay where they were, in the air, too, when the model of their lane ended.
    const shape = lane.fell !== undefined && this.time >= lane.fell ? "block fallen" : "block";
    while (svg.lastChild.tagName !== "title") svg.removeChild(svg.lastChild);
    this.drawGround(off);
    const s = this.plate;
    const [left, right] = this.plates;
    const slab = (at, down) => lane.spatial
      ? [[-s, -s], [s, -s], [s, s], [-s, s]].map((c) => put([at[0] + c[0], at[1] + c[1], at[2] + (lane.floor || 0) - down]))
      : [[left, 0], [right, 0], [right, -this.thick], [left, -this.thick]].map((c) => put([at[0] + c[0], 0, at[2] + c[1] + (lane.floor || 0) - down]));
    const line = (ends, kind) => make("line", { x1: ends[0][0], y1: ends[0][1], x2: ends[1][0], y2: ends[1][1], class: kind }, svg);
    const top = slab(base, 0);
    const ground = this.ground();
    if (ground) {
      const below = slab(ground, this.gap);
      polygon(below, { class: "base" });
      if (lane.spatial) below.forEach((foot, k) => line([foot, top[k]], "link"));
      else
        [0.15, 0.85].forEach((part) => {
          const between = (a, b) => [0, 1].map((k) => a[k] + part * (b[k] - a[k]));
          line([between(below[0], below[1]), between(top[3], top[2])], "link");
        });
      polygon(top, { class: "base" });
      if (!lane.spatial)
        [[top, "support"], [below, "ground"]].forEach(([at, name]) =>
          make("text", { x: at[0][0] + 6, y: (at[0][1] + at[3][1]) / 2 + 4 }, svg, name));
    } else polygon(top, { class: "base" });
    if (!lane.spatial && !lane.assembly) {
      const mark = [put([base[0], 0, base[2]]), put([base[0], 0, base[2] - this.thick])];
      make("line", { x1: mark[0][0], y1: mark[0][1], x2: mark[1][0], y2: mark[1][1], class: "mark" }, svg);
    }
    const parts = lane.parts || [];
    // What stands behind the block, the block, and what reaches to it.
    parts.forEach((part) => {
      const points = this.pointsOf(part).map(put);
      if (part.look === "anchor") line(points, "anchor");
      else if (part.look === "wall") polygon(points, { class: "wall" });
      else if (part.look === "column") polygon(points, { class: "block", fill: COLORS[0], stroke: COLORS[0] });
      else if (part.look === "beam") polygon(points, { class: "beam" });
    });
    if (lane.assembly && lane.spatial) this.drawSolids(put, polygon, shape, base[2] + lane.floor);
    else this.corners().forEach((corners, k) => {
      const points = corners.map(put);
      const color = COLORS[k % COLORS.length];
      if (lane.blocks[k].p) {
        if (lane.assembly) {
          polygon(points, lane.blocks[k].fixed ? { class: "base" } : { class: shape, fill: COLORS[0], stroke: COLORS[0] });
          return;
        }
        polygon(lane.spatial ? hull(points) : points, { class: shape, fill: color, stroke: color });
        const centre = put(["x", "y", "z"].map((axis) => this.at(lane.blocks[k][axis], lane.length)));
        make("circle", { cx: centre[0], cy: centre[1], r: 3, fill: color }, svg);
        return;
      }
      if (!lane.spatial) {
        polygon([0, 4, 5, 1].map((c) => points[c]), { class: shape, fill: color, stroke: color });
        return;
      }
      FACES.map((face) => face.map((c) => points[c]))
        .map((face) => [face.reduce((sum, p) => sum + p[2], 0), face])
        .sort((a, b) => b[0] - a[0])
        .slice(3)
        .forEach((pair) => polygon(pair[1], { class: shape, fill: color, stroke: color }));
    });
    parts.forEach((part) => {
      const points = this.pointsOf(part).map(put);
      const doing = this.doing(part);
      if (part.look === "tie" && doing !== "broken") line(points, "tie " + doing);
      if (part.look !== "load") return;
      const [tail, head] = points;
      const long = Math.hypot(head[0] - tail[0], head[1] - tail[1]) || 1;
      const [x, y] = [0, 1].map((k) => (head[k] - tail[k]) / long);
      const back = [head[0] - 9 * x, head[1] - 9 * y];
      line([tail, back], "load");
      polygon([head, [back[0] - 5 * y, back[1] + 5 * x], [back[0] + 5 * y, back[1] - 5 * x]], { class: "load" });
    });
    this.say(base);
  };

  // The ground that stays where it is, with a scale, and the time.
  // The blocks of an assembly in space: faces that the reader sees, those farther away first. What is
  // fixed below the ground is not shown.
  Player.prototype.drawSolids = function (put, polygon, shape, level) {
    const shown = [];
    this.corners().forEach((corners, k) => {
      const block = this.lane.blocks[k];
      const high = Math.max(...corners.map((corner) => corner[2]));
      if (block.fixed && high <= level + this.lane.length) return;
      const points = corners.map(put);
      block.f.forEach((face) => {
        const side = face.map((c) => points[c]);
        const turns = side.reduce((sum, p, i) => sum + p[0] * side[(i + 1) % side.length][1] - p[1] * side[(i + 1) % side.length][0], 0);
        // Upwards in the picture is downwards in its coordinates.
        if (turns < 0) shown.push([side.reduce((sum, p) => sum + p[2], 0) / side.length, side, block.fixed]);
      });
    });
    shown.sort((a, b) => b[0] - a[0]);
    shown.forEach(([, side, fixed]) =>
      polygon(side, fixed ? { class: "base" } : { class: shape + " solid", fill: COLORS[0], stroke: COLORS[0] }));
  };

  Player.prototype.drawGround = function (off) {
    const svg = this.scene;
    const [width, height] = this.size;
    const step = roundStep(width / this.scale, 6);
    const y = height - 18;
    make("line", { x1: 0, y1: y, x2: width, y2: y, class: "ground" }, svg);
    const first = Math.ceil((-this.shift[0] / this.scale + off[0]) / step);
    for (let k = first; (k * step - off[0]) * this.scale + this.shift[0] <= width; k++) {
      const x = (k * step - off[0]) * this.scale + this.shift[0];
      make("line", { x1: x, y1: y, x2: x, y2: y + 5, class: "ground" }, svg);
      if (!this.lane.spatial && x > 14 && x < width - 30)
        make("text", { x: x, y: height - 2, "text-anchor": "middle" }, svg, written(k * step, step) + " m");
    }
    make("text", { x: 6, y: 16, class: "clock" }, svg, [this.time.toFixed(2) + " s", this.ended()].filter(Boolean).join("   "));
    if (this.lane.spatial)
      make("text", { x: 6, y: height - 4 }, svg, "a mark on the ground every " + written(step, step) + " m");
  };

  // What is said of a lane whose model has ended, since a block of its stack fell.
  Player.prototype.ended = function () {
    const fell = this.lane.fell;
    return fell !== undefined && this.time >= fell ? (this.lane.assembly ? "followed until " + fell.toFixed(2) + " s" : "fell at " + fell.toFixed(2) + " s; what follows is not modelled") : "";
  };

  Player.prototype.say = function (base) {
    const lane = this.lane;
    const degrees = (r) => ((r * 180) / Math.PI).toFixed(2) + "°";
    const turns = lane.blocks.map((block) => Math.abs(this.at(block.r, lane.angle)));
    const parts = lane.assembly ? ["largest rotation of a block " + degrees(Math.max(...turns))] : lane.blocks.map((block, k) => {
      const r = this.at(block.r, lane.angle);
      const name = lane.blocks.length > 1 ? "block " + (k + 1) + ": " : "rotation ";
      return name + degrees(r) + " (" + (r / block.alpha[r < 0 ? 0 : 1]).toFixed(3) + " of its slenderness angle)";
    });
    if (!this.follow.closest("label").hidden)
      parts.push((lane.ground ? "support" : "base") + " moved " + (1000 * base[0]).toFixed(1) + " mm, accelerated " + this.at(lane.acc, lane.rate).toFixed(2) + " m/s²");
    if (lane.ground) parts.push("ground moved " + (1000 * this.ground()[0]).toFixed(1) + " mm");
    const ties = (lane.parts || []).filter((part) => part.states).map((part) => this.doing(part));
    if (ties.length) parts.push((ties.length > 1 ? "ties: " : "tie ") + ties.join(", "));
    if (lane.rise)
      parts.push("upwards " + (1000 * base[2]).toFixed(1) + " mm, " + this.at(lane.rise, lane.rate).toFixed(2) + " m/s²");
    if (this.ended()) parts.push(this.ended());
    const text = this.time.toFixed(2) + " s: " + parts.join("; ");
    this.now.textContent = text;
    this.slider.value = String(this.time);
    this.slider.setAttribute("aria-valuetext", text);
    const x = this.left + (this.time / this.end) * (this.right - this.left);
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
  };

  Player.prototype.drawPlot = function (width) {
    const lane = this.lane;
    const svg = this.plot;
    const shaken = lane.acc && lane.acc.some((value) => value !== 0);
    const panels = [{ title: "rotation / slenderness angle", curves: lane.blocks.map((block) => block.r.map((v) => (v * lane.angle) / block.alpha[v < 0 ? 0 : 1])), limit: 1 }];
    if (lane.assembly) {
      const moving = lane.blocks.filter((block) => !block.fixed);
      const curves = moving.map((block) => block.r.map((v) => (v * lane.angle * 180) / Math.PI));
      panels[0] = { title: "rotations of the blocks [deg]", curves: curves };
    }
    const along = lane.rise || lane.sway ? "base acceleration along x [m/s²]" : "base acceleration [m/s²]";
    if (shaken) panels.push({ title: along, curves: [lane.acc.map((v) => v * lane.rate)] });
    if (lane.sway) panels.push({ title: "base acceleration along y [m/s²]", curves: [lane.sway.map((v) => v * lane.rate)] });
    if (lane.rise) panels.push({ title: "base acceleration upwards [m/s²]", curves: [lane.rise.map((v) => v * lane.rate)] });
    const tall = [128, 86, 86, 86];
    const height = panels.reduce((sum, _, k) => sum + tall[k], 0) + 26;
    [this.width, this.left, this.right] = [width, 46, width - 8];
    svg.setAttribute("viewBox", "0 0 " + width + " " + height);
    while (svg.lastChild.tagName !== "title") svg.removeChild(svg.lastChild);
    const x = (t) => this.left + (t / this.end) * (this.right - this.left);
    let top = 0;
    panels.forEach((panel, k) => {
      this.drawPanel(panel, top, tall[k], x, k > 0);
      top += tall[k];
    });
    const step = roundStep(this.end, width < 500 ? 4 : 8);
    for (let t = 0; t <= this.end * 1.0001; t += step) {
      make("line", { x1: x(t), y1: top, x2: x(t), y2: top + 4, class: "axis" }, svg);
      make("text", { x: Math.min(x(t), width - 14), y: top + 16, "text-anchor": "middle" }, svg, written(t, step) + (t + step > this.end * 1.0001 ? " s" : ""));
    }
    this.cursor = make("line", { x1: 0, y1: 0, x2: 0, y2: top, class: "cursor" }, svg);
  };

  Player.prototype.drawPanel = function (panel, top, tall, x, plain) {
    const svg = this.plot;
    const lane = this.lane;
    let most = 0;
    panel.curves.forEach((curve) => curve.forEach((v) => (most = Math.max(most, Math.abs(v)))));
    if (panel.limit) most = Math.min(most, 1.6 * panel.limit);
    most = 1.08 * (most || 1);
    const y = (v) => top + 20 + (tall - 26) * (0.5 - v / (2 * most));
    const step = roundStep(2 * most, 6);
    for (let k = Math.ceil(-most / step); k * step <= most; k++) {
      make("line", { x1: this.left, y1: y(k * step), x2: this.right, y2: y(k * step), class: k === 0 ? "axis" : "grid" }, svg);
      make("text", { x: this.left - 5, y: y(k * step) + 4, "text-anchor": "end" }, svg, written(k * step, step));
    }
    make("text", { x: this.left, y: top + 13, class: "title" }, svg, panel.title);
    if (panel.limit && most > panel.limit)
      [-1, 1].forEach((side) => make("line", { x1: this.left, y1: y(side), x2: this.right, y2: y(side), class: "limit" }, svg));
    panel.curves.forEach((curve, k) => {
      const cut = Math.max(most, 1e-12);
      const path = curve.map((v, i) => (i ? "L" : "M") + x(i * lane.dt).toFixed(1) + " " + y(Math.max(-cut, Math.min(cut, v))).toFixed(1));
      make("path", { d: path.join(""), fill: "none", stroke: plain ? "#555" : COLORS[k % COLORS.length], "stroke-width": 1.4 }, svg);
      if (panel.curves.length > 1 && !lane.assembly)
        make("text", { x: this.right - 62 * (panel.curves.length - 1 - k), y: top + 13, "text-anchor": "end", style: "fill:" + COLORS[k % COLORS.length] }, svg, "block " + (k + 1));
    });
  };

  // ---- start ---------------------------------------------------------------------------------

  document.documentElement.classList.add("scripted");
  document.querySelectorAll("figure.sheet").forEach(setUpTable);
  const players = Array.from(document.querySelectorAll(".player")).map((root) => new Player(root));
  document.querySelectorAll("button.show-lane").forEach(function (button) {
    button.addEventListener("click", function () {
      const player = players.find((each) => each.root.dataset.scenes === button.dataset.scenes);
      const at = player.lanes.findIndex((lane) => lane.lane === Number(button.dataset.lane));
      player.load(at);
      player.root.scrollIntoView({ block: "start" });
      player.button.focus({ preventScroll: true });
    });
  });
})();
