#pragma once

namespace battery_sof {

// Texts that every page holds, embedded when the package is built (cmake/embed_page_assets.cmake).
extern const char kPageCss[];  ///< src/report/page/page.css
extern const char kPageJs[];   ///< src/report/page/page.js
// The plot library of Debian's package libjs-dygraphs; empty where it was not installed at build
// time.
extern const char kDygraphsJs[];
extern const char kDygraphsCss[];
extern const char kDygraphsNotice[];  ///< its licence, which goes wherever it goes

}  // namespace battery_sof
