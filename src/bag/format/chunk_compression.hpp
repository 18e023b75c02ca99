#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace battery_sof {

/**
 * @brief The bytes of a chunk as they were before compression.
 * @param compression "bz2" or "lz4" (frames of LZ4), as a chunk's header has it.
 * @param size of the result, as the header has it.
 * @throws std::runtime_error when the bytes are damaged, make another size, or are compressed in
 * another way.
 */
std::string decompressed(std::string_view compression, std::string_view bytes, std::size_t size);

}  // namespace battery_sof
