"""Pictures that `radiosity bench references --trace` wrote: radiance, noise of the blocks, and what glass throws."""
