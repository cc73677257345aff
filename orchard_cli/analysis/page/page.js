(function () {
  var charts = JSON.parse(document.getElementById("charts").textContent);
  var drawn = [];
  var webgl = (function () {
    try { return !!document.createElement("canvas").getContext("webgl"); } catch (e) { return false; }
  })();
  document.querySelectorAll("[data-chart]").forEach(function (place) {
    var name = place.dataset.chart;
    if (name === "space" && !webgl) {
      place.textContent = "This browser does not draw in three dimensions (no WebGL).";
      place.classList.add("none");
      return;
    }
    var narrow = window.matchMedia("(max-width: 600px)").matches;
    Plotly.newPlot(place, charts[name].data, charts[name].layout,
      { responsive: true, displaylogo: false, displayModeBar: narrow ? false : "hover",
        scrollZoom: false });
    drawn.push(place);
  });
  function fit(width) {
    drawn.forEach(function (place) {
      Plotly.relayout(place, width ? { width: width, autosize: false } : { width: null, autosize: true });
    });
  }
  window.addEventListener("beforeprint", function () { fit(680); });
  window.addEventListener("afterprint", function () { fit(0); });
})();
