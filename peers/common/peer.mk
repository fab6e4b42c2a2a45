# What the Makefiles of the peers in C++ share. Before: NAME, the folder SOURCE of the library, STANDARD.
CXXFLAGS ?= -O3 -march=native
COMMIT ?= $(shell test -e "$(SOURCE)/.git" && git -C "$(SOURCE)" rev-parse --short HEAD)
HEADERS = ../common/peer.h ../common/peer.mk ../../crates/plugins/include/rtbench.h
COMPILE = $(CXX) -std=$(STANDARD) $(CXXFLAGS) -DNDEBUG $(if $(COMMIT),-DCOMMIT='"$(COMMIT)"') \
	-fPIC -shared -pthread -I../common -I../../crates/plugins/include -isystem $(SOURCE)

clean:
	rm -f *.so
.PHONY: clean
