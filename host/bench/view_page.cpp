#include "bench/view_page.hpp"

#include "bench/page_text.hpp"
#include "pages.hpp"

namespace regulus::bench {

std::string view_page(const nlohmann::json& view) {
  return filled_page(VIEW_PAGE, view);
}

}  // namespace regulus::bench
