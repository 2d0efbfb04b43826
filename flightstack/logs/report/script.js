"use strict";
const figures = JSON.parse(document.getElementById("figures").textContent);
const settings = {
  responsive: true,
  displaylogo: false,
  showSendToCloud: false,  // a flight's data stay on this page
  modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
  toImageButtonOptions: { format: "svg", filename: document.title },
};
for (const [name, figure] of Object.entries(figures)) {
  Plotly.newPlot(`figure-${name}`, figure.data, figure.layout, settings);
}
