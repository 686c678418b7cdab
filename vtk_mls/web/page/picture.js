/* The picture: shows frames, sends mouse and keys. */
(() => {
  const TAKEN_OVER = 4001;
  const ARROWS = ["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"];
  const NAMED_KEYS = ["Delete", "Backspace", "Escape", "Enter", " ", ...ARROWS];
  const CONTROL_KEYS = "aszy";
  const WHEEL_STEP = 40; // pixels
  const ZOOM_PER_STEP = 1.21;
  const STILL = 6; // pixels that a finger may move during a tap
  const DOUBLE_TIME = 400; // milliseconds from the first press to the second
  const DOUBLE_CLICK = 6, DOUBLE_TOUCH = 24; // pixels between both

  const distance = (a, b) => Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
  const clamp = (value, limit) => Math.max(-limit, Math.min(value, limit));
  const LOST = `<div class="mls-veil mls-whole" role="alertdialog">
    <p>The connection to the server is lost. Unsaved edits are kept.</p>
    <p>If the server has ended, run <code>vtk-mls view</code> again with the same file: it offers them.</p>
    <button class="mls-button" onclick="location.reload()">Load the page again</button></div>`;

  const isTyping = (target) =>
    target.closest && target.closest("input, textarea, [contenteditable], .v-overlay");

  const Picture = {
    props: ["name", "several"],
    emits: ["save", "menu"],
    data: () => ({ state: "opening", wheel: 0 }),
    template: `
      <div class="mls-picture" ref="box">
        <canvas ref="canvas" tabindex="0" :aria-label="name" @contextmenu.prevent
          @pointerdown="down" @pointermove="move" @pointerup="up" @pointercancel="up"
          @pointerleave="leave" @wheel.prevent="turn"></canvas>
        <div v-if="state === 'opening'" class="mls-veil"><span class="mls-ring"></span></div>
        <div v-if="state === 'closed'" class="mls-veil">
          <p>The server does not answer. Connecting again; nothing is lost.</p></div>
        <div v-if="state === 'taken_over'" class="mls-veil mls-whole" role="alertdialog">
          <p>This session goes on in another tab.</p>
          <button class="mls-button" @click="connect">Continue here</button></div>
      </div>`,
    created() {
      this.touches = {};
    },
    mounted() {
      this.context = this.$refs.canvas.getContext("2d");
      this.watcher = new ResizeObserver(() => this.resize());
      this.watcher.observe(this.$refs.box);
      this.onKey = (event) => this.key(event);
      document.addEventListener("keydown", this.onKey);
      this.connect();
      this.$refs.canvas.focus({ preventScroll: true });
    },
    unmounted() {
      document.removeEventListener("keydown", this.onKey);
      this.watcher.disconnect();
      clearTimeout(this.retry); // a dead tab must not take the session from a new one
      this.socket.onclose = null;
      this.socket.close();
      // trame takes the page down when its own socket closes
      document.body.insertAdjacentHTML("beforeend", LOST);
    },
    methods: {
      connect() {
        this.state = "opening";
        const address = new URL("picture", document.baseURI);
        address.protocol = address.protocol.replace("http", "ws");
        const socket = (this.socket = new WebSocket(address));
        socket.binaryType = "blob";
        socket.onopen = () => this.resize();
        socket.onmessage = (message) => this.show(message.data);
        socket.onclose = (event) => {
          if (socket !== this.socket) return;
          this.state = event.code === TAKEN_OVER ? "taken_over" : "closed";
          if (this.state === "closed") this.retry = setTimeout(() => this.connect(), 1500);
        };
      },
      send(event) {
        if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(event));
      },
      async show(blob) {
        const image = await createImageBitmap(blob);
        const canvas = this.$refs.canvas;
        if (canvas) {
          if (canvas.width !== image.width) canvas.width = image.width;
          if (canvas.height !== image.height) canvas.height = image.height;
          this.context.drawImage(image, 0, 0);
          canvas.dataset.frames = 1 + Number(canvas.dataset.frames || 0);
        }
        image.close();
        this.state = "open";
        this.send({ type: "shown" });
      },
      resize() {
        const { width, height } = this.$refs.box.getBoundingClientRect();
        if (width && height) this.send({ type: "size", w: width, h: height });
      },
      event(type, pointer, more) {
        const box = this.$refs.canvas.getBoundingClientRect();
        this.send({
          type,
          x: (pointer.clientX - box.left) / box.width,
          y: (pointer.clientY - box.top) / box.height,
          ctrl: pointer.ctrlKey || pointer.metaKey || this.several,
          shift: pointer.shiftKey,
          ...more,
        });
      },
      down(event) {
        this.$refs.canvas.focus({ preventScroll: true });
        this.$refs.canvas.setPointerCapture(event.pointerId);
        this.touches[event.pointerId] = event;
        const count = Object.keys(this.touches).length;
        if (count === 1) {
          const { pressed } = this;
          this.isSecond = pressed && event.button === 0 && event.timeStamp - pressed.timeStamp < DOUBLE_TIME &&
            distance(event, pressed) < (event.pointerType === "touch" ? DOUBLE_TOUCH : DOUBLE_CLICK);
          // it may become a double click, or the first finger of two
          if (this.isSecond || event.pointerType === "touch") this.waiting = event;
          else this.press(event);
        } else if (count === 2) {
          this.flush();
          if (!this.waiting) this.event("cancel", event, { button: 0 });
          this.waiting = undefined;
          this.pinch = this.fingers();
        }
        event.preventDefault();
      },
      press(event) {
        this.waiting = undefined;
        this.pressed = event;
        this.event("move", event);
        this.event("down", event, { button: event.button });
      },
      move(event) {
        if (this.touches[event.pointerId]) this.touches[event.pointerId] = event;
        if (this.waiting) {
          if (distance(event, this.waiting) <= STILL) return;
          this.press(this.waiting);
        }
        if (this.pinch && Object.keys(this.touches).length !== 2) return;
        this.lastMove = event;
        this.moveRequest ??= requestAnimationFrame(() => this.flush());
      },
      flush() {
        if (!this.moveRequest) return;
        cancelAnimationFrame(this.moveRequest);
        this.moveRequest = undefined;
        if (!this.pinch) return this.event("move", this.lastMove);
        const before = this.pinch;
        this.pinch = this.fingers();
        this.zoom(this.pinch, this.pinch.spread / before.spread, before);
      },
      up(event) {
        const count = Object.keys(this.touches).length;
        if (this.pinch && count === 2) this.flush();
        delete this.touches[event.pointerId];
        if (count !== 1) return;
        if (this.pinch) return (this.pinch = undefined);
        if (this.waiting && this.isSecond) {
          this.waiting = this.pressed = undefined;
          return this.event("double", event);
        }
        if (this.waiting) this.press(this.waiting);
        this.flush();
        this.event("up", event, { button: Math.max(event.button, 0) });
      },
      leave(event) {
        if (!Object.keys(this.touches).length) this.send({ type: "leave" });
      },
      fingers() {
        const [a, b] = Object.values(this.touches);
        const clientX = (a.clientX + b.clientX) / 2, clientY = (a.clientY + b.clientY) / 2;
        return { clientX, clientY, spread: Math.max(distance(a, b), 1) };
      },
      turn(event) {
        const pixels = event.deltaMode ? event.deltaY * WHEEL_STEP : event.deltaY;
        // browsers say that Ctrl is down for a pinch on a touch pad
        if (event.ctrlKey || event.metaKey)
          return this.zoom(event, ZOOM_PER_STEP ** (-clamp(pixels, 2 * WHEEL_STEP) / WHEEL_STEP));
        this.wheel -= pixels;
        const steps = Math.trunc(this.wheel / WHEEL_STEP);
        this.wheel -= steps * WHEEL_STEP;
        if (steps) this.event("wheel", event, { steps });
      },
      zoom(at, factor, from = at) {
        const box = this.$refs.canvas.getBoundingClientRect();
        this.event("zoom", from, {
          factor,
          dx: (at.clientX - from.clientX) / box.width,
          dy: (at.clientY - from.clientY) / box.height,
        });
      },
      key(event) {
        const control = event.ctrlKey || event.metaKey;
        const letter = event.key.toLowerCase();
        if (isTyping(event.target) || event.altKey || this.state === "taken_over") return;
        if (control ? !CONTROL_KEYS.includes(letter) : event.key.length > 1 && !NAMED_KEYS.includes(event.key))
          return;
        if ([" ", "Enter"].includes(event.key) && event.target.closest("button, a")) return;
        if (ARROWS.includes(event.key) && event.target.closest("[role=slider]")) return;
        event.preventDefault();
        if (letter === "s") this.$emit("save");
        else if (letter === "h" || event.key === "?") this.$emit("menu");
        else if (letter !== "q") this.send({ type: "key", key: event.key, ctrl: control, shift: event.shiftKey });
      },
    },
  };

  /* A button that uploads a file, and emits the answer of the server. */
  const Send = {
    props: ["kind", "label", "icon", "limit"],
    emits: ["answer"],
    data: () => ({ percent: null }),
    template: `
      <v-btn block variant="tonal" :prepend-icon="icon" :loading="percent !== null"
        @click="$refs.file.click()">{{ label }}
        <template #loader><v-progress-circular size="20" width="2" :model-value="percent"
          :indeterminate="percent === 100"></v-progress-circular></template>
        <input type="file" ref="file" hidden :data-send="kind"
          @change="send" @click.stop>
      </v-btn>`,
    methods: {
      send() {
        const file = this.$refs.file.files[0];
        this.$refs.file.value = "";
        if (!file) return;
        if (file.size > this.limit)
          return this.$emit("answer", `${file.name} has more than ${this.limit >> 20} MB, which is the limit.`);
        const request = new XMLHttpRequest();
        request.open("POST", new URL(`send/${this.kind}/${encodeURIComponent(file.name)}`, document.baseURI));
        request.upload.onprogress = (event) => (this.percent = (100 * event.loaded) / event.total);
        request.onloadend = () => {
          this.percent = null;
          this.$emit("answer", request.responseText || "The server does not answer.");
        };
        this.percent = 0;
        request.send(file);
      },
    },
  };

  window.vtkMlsPage = {
    install(app) {
      app.component("mls-picture", Picture);
      app.component("mls-send", Send);
    },
  };
})();
