"""Commands of ``radiosity`` that neither golden nor hw has."""
