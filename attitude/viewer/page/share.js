// The picture with its labels, title, date and light curve as one PNG: shared, or saved.

const EDGE = 12; // pixels of the page

// A canvas of what is shown.
export function pictureOf({ data, stage, clock, curve }) {
  const { clientWidth: width, clientHeight: height } = stage.canvas.parentElement;
  const below = curve ? curve.canvas.clientHeight : 0;
  const ratio = 2;
  const canvas = document.createElement("canvas");
  canvas.width = ratio * width;
  canvas.height = ratio * (height + below);
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.fillStyle = "#10131a";
  pen.fillRect(0, 0, width, height + below);
  pen.drawImage(stage.canvas, 0, 0, width, height);
  pen.textBaseline = "top";
  pen.font = "12px system-ui, sans-serif";
  for (const { text, color, x, y } of stage.labels.shown()) {
    pen.fillStyle = color;
    pen.fillText(text, x + 3, y + 2);
  }
  pen.fillStyle = "#e4e7ee";
  pen.font = "600 15px system-ui, sans-serif";
  pen.fillText(data.title, EDGE, EDGE, width - 2 * EDGE);
  pen.font = "12px ui-monospace, monospace";
  const words = stage.shade ? stage.shade.words(clock.time) : "";
  pen.fillText([clock.utc(), words].filter(Boolean).join(", "), EDGE, height - EDGE - 12);
  if (curve) pen.drawImage(curve.canvas, 0, height, width, below);
  return canvas;
}

export function listenToShare(parts) {
  const { data, clock } = parts;
  document.getElementById("share").addEventListener("click", () => {
    pictureOf(parts).toBlob(async (blob) => {
      const words = `${data.title} ${clock.utc()}`.replace(/[^\w+-]+/g, "-");
      const file = new File([blob], `${words}.png`, { type: "image/png" });
      if (navigator.canShare?.({ files: [file] })) {
        try {
          await navigator.share({ files: [file], title: data.title });
          return;
        } catch (error) {
          if (error.name === "AbortError") return; // the reader thought better of it
        }
      }
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      link.download = file.name;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 60000);
    });
  });
}
