#include "bag/format/chunk_compression.hpp"

#include <bzlib.h>
#include <lz4frame.h>

#include <memory>
#include <stdexcept>

namespace battery_sof {

namespace {

/// @return how many bytes there are, or nothing of that size.
std::size_t decompressBzip2(std::string_view bytes, std::string& content) {
  auto size = static_cast<unsigned int>(content.size());
  const int result =
      ::BZ2_bzBuffToBuffDecompress(content.data(), &size, const_cast<char*>(bytes.data()),
                                   static_cast<unsigned int>(bytes.size()), 0, 0);
  return result == BZ_OK ? size : std::string::npos;
}

/// Likewise.
std::size_t decompressLz4(std::string_view bytes, std::string& content) {
  LZ4F_dctx* made = nullptr;
  if (::LZ4F_isError(::LZ4F_createDecompressionContext(&made, LZ4F_VERSION)))
    throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, decltype(&::LZ4F_freeDecompressionContext)> context(
      made, &::LZ4F_freeDecompressionContext);
  std::size_t read = 0, written = 0, hint = 1;
  while (hint > 0) {
    std::size_t taken = bytes.size() - read, given = content.size() - written;
    hint = ::LZ4F_decompress(context.get(), content.data() + written, &given, bytes.data() + read,
                             &taken, nullptr);
    if (::LZ4F_isError(hint) || (taken == 0 && given == 0)) return std::string::npos;
    read += taken;
    written += given;
  }
  return written;
}

}  // namespace

std::string decompressed(std::string_view compression, std::string_view bytes, std::size_t size) {
  std::string content(size, '\0');
  std::size_t found = std::string::npos;
  if (compression == "bz2") found = decompressBzip2(bytes, content);
  if (compression == "lz4") found = decompressLz4(bytes, content);
  if (found != size) throw std::runtime_error("a chunk cannot be decompressed");
  return content;
}

}  // namespace battery_sof
