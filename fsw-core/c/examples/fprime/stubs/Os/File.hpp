// STUB of F Prime's Os::File: one file in memory.
#ifndef OS_FILE_STUB_HPP
#define OS_FILE_STUB_HPP

#include <cstring>
#include <vector>

#include "InertiaEstimatorComponentAc.hpp"

namespace Os {

class File {
  public:
    enum Mode { OPEN_READ, OPEN_CREATE };
    enum Status { OP_OK, DOESNT_EXIST };

    Status open(const char*, Mode mode) {
        this->m_at = 0;
        if (mode == OPEN_CREATE) {
            contents().clear();
        }
        return OP_OK;
    }

    Status write(const U8* bytes, FwSizeType& size) {
        contents().insert(contents().end(), bytes, bytes + size);
        return OP_OK;
    }

    Status read(U8* bytes, FwSizeType& size) {
        const FwSizeType left = contents().size() - this->m_at;
        size = size < left ? size : left;
        std::memcpy(bytes, contents().data() + this->m_at, size);
        this->m_at += size;
        return OP_OK;
    }

    void close() {}

  private:
    static std::vector<U8>& contents() {
        static std::vector<U8> bytes;
        return bytes;
    }

    FwSizeType m_at = 0;
};

}  // namespace Os

#endif
