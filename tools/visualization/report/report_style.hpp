#pragma once

namespace colift::picture {

/// Style of the report page: light and dark by the reader's preference, light and unbroken in print.
inline constexpr const char* kReportStyle = R"css(
:root{--paper:#fff;--panel:#f6f7f9;--ink:#1d2530;--soft:#5a6573;--rule:#d9dee4;--bar:#0072b2;color-scheme:light dark}
@media (prefers-color-scheme:dark){:root{--paper:#161a1f;--panel:#1f252c;--ink:#e6e9ed;--soft:#9aa5b1;--rule:#343c46;--bar:#56b4e9}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 system-ui,"DejaVu Sans",sans-serif}
main{max-width:72rem;margin:0 auto;padding:2rem 1.25rem 4rem}
h1{font-size:1.8rem;line-height:1.2;margin:0 0 1rem}
h2{font-size:1.15rem;margin:2.25rem 0 .6rem}
p{max-width:46rem;margin:.5rem 0}
.lead{font-size:1.12rem}
.warning{font-size:1.12rem;font-weight:600;color:#fff;background:#b3261e;padding:.5rem .8rem;border-radius:.4rem}
figure{margin:1.5rem 0}
img{max-width:100%;height:auto;border:1px solid var(--rule);border-radius:6px;background:#fff}
figcaption{color:var(--soft);font-size:.92rem;margin-top:.35rem}
.wide{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.92rem}
th,td{text-align:left;vertical-align:top;padding:.35rem .7rem .35rem 0;border-bottom:1px solid var(--rule)}
th{color:var(--soft);font-weight:600}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
td.why{overflow-wrap:anywhere;min-width:14rem}
tr.chosen td{background:var(--panel);font-weight:600}
.chip{display:inline-block;padding:.05rem .55rem;border-radius:1rem;font-size:.82rem;font-weight:600;white-space:nowrap}
.state{display:inline-block;padding:.05rem .55rem;border-radius:.3rem;font-size:.85em;font-weight:600;white-space:nowrap;background:var(--panel);border:1px solid var(--rule)}
h1 .state{font-size:.55em;vertical-align:.25em;margin-left:.4rem}
.good{background:#00805e;border-color:#00805e;color:#fff}.bad{background:#b3460a;border-color:#b3460a;color:#fff}.odd{background:#8a4b78;border-color:#8a4b78;color:#fff}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(8.5rem,1fr));gap:.75rem;margin:1.5rem 0}
.cards div{background:var(--panel);border:1px solid var(--rule);border-radius:6px;padding:.7rem .9rem;display:flex;flex-direction:column}
.cards b{font-size:1.5rem;line-height:1.2;font-variant-numeric:tabular-nums}.cards small{color:var(--soft);font-size:.82rem;margin-top:.2rem}
.pair{display:grid;grid-template-columns:repeat(auto-fit,minmax(22rem,1fr));gap:0 1rem}.pair figure{margin:.75rem 0}
td.when,th.when{min-width:9rem;width:26%}td.when i{display:block;height:.8rem;min-width:3px;background:var(--bar);border-radius:3px;margin-top:.35rem}
table.narrow{width:auto}table.narrow td,table.narrow th{padding-right:1.6rem}
dl{display:grid;grid-template-columns:minmax(8rem,max-content) 1fr;gap:.25rem 1.25rem;margin:0;font-size:.95rem}
dt{color:var(--soft)}dd{margin:0;overflow-wrap:anywhere}
.bars{display:grid;grid-template-columns:max-content 1fr max-content;gap:.3rem .9rem;align-items:center;max-width:46rem;font-size:.92rem}
.bars div{background:var(--panel);border-radius:3px}
.bars i{display:block;height:.8rem;background:var(--bar);border-radius:3px}
.bars b{font-weight:400;text-align:right;font-variant-numeric:tabular-nums}
pre{background:var(--panel);border:1px solid var(--rule);border-radius:6px;padding:.8rem 1rem;white-space:pre-wrap;overflow-wrap:anywhere;font-size:.9rem}
@media print{:root{--paper:#fff;--panel:#f6f7f9;--ink:#000;--soft:#444;--rule:#bbb;--bar:#0072b2}
main{max-width:none;padding:0}figure,tr,.bars,.cards{break-inside:avoid}h2{break-after:avoid}
.chip,.state,td.when i,.cards div,.bars i,.bars div,tr.chosen td{-webkit-print-color-adjust:exact;print-color-adjust:exact}thead{display:table-header-group}}
)css";

}  // namespace colift::picture
