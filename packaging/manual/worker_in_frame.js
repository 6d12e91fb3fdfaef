// A worker for pages that are opened from a disk, where browsers refuse workers: its script runs in a hidden frame.
window.Worker = class extends EventTarget {
  constructor(url) {
    super();
    this.waiting = [];
    const frame = document.createElement("iframe");
    frame.hidden = true;
    frame.title = "search";
    const name = `fromWorker${Math.random().toString(36).slice(2)}`;
    window[name] = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
    frame.srcdoc = `<script>self.postMessage = (data) => parent.${name}(data);
      self.importScripts = () => { throw new Error("no further scripts"); };<\/script>
      <script src="${new URL(url, location.href).href}"><\/script>`;
    frame.addEventListener("load", () => {
      this.frame = frame;
      for (const data of this.waiting.splice(0)) this.postMessage(data);
    });
    document.body.append(frame);
  }
  postMessage(data) {
    if (this.frame) this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }));
    else this.waiting.push(data);
  }
  terminate() {
    this.frame?.remove();
  }
};
