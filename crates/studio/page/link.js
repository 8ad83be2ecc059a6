// The connection to the engine: requests out, the newest view, strips and frame in.

export class Link {
  constructor(handlers) {
    this.handlers = handlers;
    this.received = { frames: 0, bytes: 0 };
    this.open();
  }

  open() {
    const socket = new WebSocket(new URL("live", location.href.replace(/^http/, "ws")));
    socket.binaryType = "arraybuffer";
    socket.addEventListener("message", ({ data }) => this.take(data, socket));
    socket.addEventListener("open", () => this.handlers.connected(true));
    socket.addEventListener("close", () => {
      this.handlers.connected(false);
      setTimeout(() => this.open(), 600);
    });
    this.socket = socket;
  }

  take(data, socket) {
    if (typeof data === "string") {
      const message = JSON.parse(data);
      // A refusal is an answer to this viewer alone, and is not acknowledged.
      if (message.refused) return this.handlers.refused(message.refused);
      this.handlers.view(message);
    } else {
      const view = new DataView(data);
      this.received.frames += view.getUint8(0) === 1 ? 1 : 0;
      this.received.bytes = data.byteLength;
      if (view.getUint8(0) === 1) this.handlers.frame(view);
      else this.handlers.strips(view);
    }
    socket.send("seen");
  }

  send(request) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }

  // An operation on the scene: what the command line takes with --do.
  operate(operation) { this.send({ operation }); }
}
